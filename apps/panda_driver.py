"""Drives a Panda through panda-python: `remosplat panda-driver`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["panda-driver", *sys.argv[1:]]))
