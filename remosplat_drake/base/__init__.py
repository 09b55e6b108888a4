"""Modules that all packages use: errors, ranges, files, processes, clocks."""
