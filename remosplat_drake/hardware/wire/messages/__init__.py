"""Our own LCM types.

The Python beside each `.lcm` file is generated, `lcm-gen -p *.lcm` in this
folder (lcm-gen comes with the development tools); it needs no LCM runtime.
"""
