"""Drives a base that speaks ROS: `remosplat base-driver`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["base-driver", *sys.argv[1:]]))
