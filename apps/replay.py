"""Plays a recorded session: the same as `remosplat replay`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["replay", *sys.argv[1:]]))
