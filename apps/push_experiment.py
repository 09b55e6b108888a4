"""Draws the paper's figure 5: the same as `remosplat push-experiment`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["push-experiment", *sys.argv[1:]]))
