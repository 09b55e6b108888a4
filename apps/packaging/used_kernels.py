"""Runs the default scenario, plans in it, and lists the kernels used.

`python -m apps.packaging.used_kernels '{time_limit: 5}'` prints their files.
"""

import sys
from collections.abc import Iterator
from contextlib import redirect_stdout

from remosplat_drake.app.scenario import DEFAULT_SCENARIO, load_scenario
from remosplat_drake.app.warm_up import compile_kernels
from remosplat_drake.app.world import load_world
from remosplat_drake.base.kernels import files, variant
from remosplat_drake.base.kernels.variant import Variant
from remosplat_drake.commands.main import main


def used(text: str) -> Iterator[Variant]:
    """Yields the kernels on disk that a run needs.

    Args:
        text: YAML that overrides fields of the scenario.
    """
    flags = ["--headless", "--scenario-text", text]
    with redirect_stdout(sys.stderr):
        if main(["run", DEFAULT_SCENARIO, *flags]):
            raise SystemExit("the default scenario fails")
        scenario = load_scenario(DEFAULT_SCENARIO, text)
        compile_kernels(scenario, load_world(scenario))
    for found in variant.variants:
        # Contained kernels are needed only if Python calls them.
        is_needed = found.kernel.content or found.was_kept
        if found.uses is not None and is_needed and found.is_kept:
            yield found


if __name__ == "__main__":
    for kernel in used(sys.argv[1]):
        print(files.find(kernel.file))
