"""Lets an operator move the target: the same as `remosplat teleop`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["teleop", *sys.argv[1:]]))
