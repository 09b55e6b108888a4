"""Makes what is shipped of this project: lists and wheels."""
