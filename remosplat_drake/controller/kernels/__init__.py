"""The control tick as a chain of compiled kernels: arrays in, arrays out."""
