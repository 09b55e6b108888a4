"""Verifies commands: the tick and its whole braking ramp are checked.

A command and its braking ramp define one path. `verify` queries the map along
this path, and scales the command until the path is free.
"""
