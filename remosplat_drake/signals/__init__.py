"""Every value that crosses a port, as immutable data.

Systems of different rooms exchange only these values, so a system that reads a
value does not depend on the system that made it. Copying such a value returns
the object itself, since Drake's ports deep-copy Python values.
"""
