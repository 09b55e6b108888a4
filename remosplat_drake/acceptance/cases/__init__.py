"""Cases of the fault campaign; each file has a tuple `CASES` for one theme."""
