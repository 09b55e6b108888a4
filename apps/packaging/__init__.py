"""Makes the lists and wheels that are shipped."""
