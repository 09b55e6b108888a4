"""Stands in for the real robot: `remosplat hardware-sim`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["hardware-sim", *sys.argv[1:]]))
