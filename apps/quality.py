"""Measures a splat against its capture: the same as `remosplat quality`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["quality", *sys.argv[1:]]))
