"""Renders RGB-D views of a scene: the same as `remosplat render-capture`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["render-capture", *sys.argv[1:]]))
