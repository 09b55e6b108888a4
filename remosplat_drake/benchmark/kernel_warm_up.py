"""Compiles what trials need, before many workers would at once.

Numba numbers the files of a kernel's variants. Processes that compile
different variants at the same time may give them the same number.
"""

import dataclasses as dc
from collections.abc import Sequence
from contextlib import suppress

from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.benchmark.trial_queue import SplatMaking
from remosplat_drake.capture.rendering.synthetic import (
    render_capture,
    survey_poses,
)
from remosplat_drake.reconstruction.surfels.surfels import surfels_from_capture

TICKS = 2
"""How long a method runs to have everything compiled."""


def compile_kernels(
    trials: Sequence[Trial], splats: SplatMaking | None
) -> None:
    """Runs each method for some ticks here, and renders some small views.

    What fails here fails again in a worker, and is recorded there.

    Args:
        trials: Of which the first of each method is run. One's own
            controllers are left out.
        splats: Whether scenes get splats.
    """
    firsts = {trial.method.name: trial for trial in reversed(trials)}
    for trial in firsts.values():
        method = trial.method
        if method.controller:
            continue
        limit = TICKS * method.scenario.control_period
        scenario = dc.replace(method.scenario, time_limit=limit)
        brief = dc.replace(method, scenario=scenario)
        with suppress(Exception):
            run_trial(dc.replace(trial, method=brief))
    truth = trials[0].case.task().solids
    if splats is not None and truth is not None:
        with suppress(Exception):
            poses = survey_poses(truth, 2)
            surfels_from_capture(render_capture(truth, poses, 64, 48), 100)
