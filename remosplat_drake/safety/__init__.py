"""Verification, braking and supervision of commands."""
