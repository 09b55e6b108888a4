"""Shared foundations: errors, ranges, files, processes and clocks."""
