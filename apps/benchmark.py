"""Compares controllers in many scenes: the same as `remosplat benchmark`."""

import sys

from remosplat_drake.commands.main import main

if __name__ == "__main__":  # Its workers import this file.
    sys.exit(main(["benchmark", *sys.argv[1:]]))
