"""LCM types of this package, in addition to Drake's.

The Python modules are generated from the `.lcm` files, by `lcm-gen -p *.lcm` in
this folder. lcm-gen is one of the development tools; the generated code needs
no LCM runtime.
"""
