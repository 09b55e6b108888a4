"""Types of the values that cross Drake's ports; all values are immutable.

Systems of different rooms exchange only these values. So a system that reads a
value does not depend on the system that made the value. Drake's ports deep-copy
Python values; a copy of these values is the object itself.
"""
