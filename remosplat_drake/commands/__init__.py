"""The `remosplat` command line, with one file per command."""
