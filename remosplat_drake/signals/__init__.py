"""Every value that crosses a port, as immutable data.

Systems of different rooms meet here and nowhere else: who reads a value need
not know who makes it. Copying such a value returns the object itself, since
Drake's ports deep-copy what is written in Python.
"""
