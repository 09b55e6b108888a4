"""The `remosplat` command line, one file a command."""
