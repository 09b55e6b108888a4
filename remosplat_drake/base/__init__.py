"""What every room may use: errors, ranges, files, processes and clocks."""
