"""Verifies commands: the tick and its whole braking ramp are checked.

A command and the ramp that brings it to rest are one path. `verify` queries the
map along it and passes as much of a command as leaves the path free.
"""
