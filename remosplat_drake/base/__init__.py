"""Modules that all rooms use: errors, ranges, files, processes, clocks."""
