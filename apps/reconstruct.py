"""Makes a splat from an RGB-D capture: the same as `remosplat reconstruct`."""

import sys

from remosplat_drake.commands.main import main

sys.exit(main(["reconstruct", *sys.argv[1:]]))
