"""Runs a scenario: the same as `remosplat teleop`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["run", *sys.argv[1:]]))
