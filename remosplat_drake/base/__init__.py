"""Basic modules for all others: errors, ranges, files, processes, clocks."""
