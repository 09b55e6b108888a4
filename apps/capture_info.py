"""Checks an RGB-D capture: the same as `remosplat capture-info`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["capture-info", *sys.argv[1:]]))
