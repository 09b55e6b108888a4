"""Cases of the fault campaign; each file contains a tuple `CASES`."""
