"""The compiled tick."""
