"""Stands in for the wrist camera: `remosplat camera-sim`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["camera-sim", *sys.argv[1:]]))
