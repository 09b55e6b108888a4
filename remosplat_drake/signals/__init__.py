"""Every value that crosses a port, as immutable data.

Systems of different rooms exchange only these values, so the reader of a value
does not depend on its producer. Copying such a value returns the object itself,
since Drake's ports deep-copy Python values.
"""
