"""Covers a robot with spheres: the same as `remosplat fit-spheres`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["fit-spheres", *sys.argv[1:]]))
