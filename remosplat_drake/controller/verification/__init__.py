"""Verifies commands: checks the tick and its whole braking ramp.

A command and its braking ramp define a path. The kernel `verified` checks this
path, and scales the command until its path is free. The module `verify` states
the guarantee.
"""
