"""Simulated operators: does anything that was mapped get touched?

Each wants anything at any time, inside of the furniture, too, while the map
changes; see `RandomOperator`. `operator_judge.py` says what counts.
"""

import dataclasses as dc
import shutil
from pathlib import Path
from time import perf_counter

from apps.studies.operators.judge import judge
from apps.studies.operators.result import OperatorResult
from apps.studies.operators.run import operate
from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world

SCENARIOS = ("StudioFree", "StudioLive")
"""They take turns."""

LATENCY = 3.0
"""A map takes effect so long after it was asked for [s]."""


@dc.dataclass(frozen=True)
class OperatorTrial:
    """One operator.

    Attributes:
        scenario: What is operated.
        seed: The operator's.
        duration: In simulated time [s].
        folder: Gets the session.
        text: Laid over the scenario.
    """

    scenario: str
    seed: int
    duration: float
    folder: str
    text: str = f"{{mapping: {{latency: {LATENCY}}}}}"

    @property
    def key(self) -> str:
        """Equal keys, equal trials."""
        return f"{self.scenario} seed {self.seed} {self.duration:g} s"


def make_trials(
    count: int, minutes: float, seed: int, folder: Path
) -> list[OperatorTrial]:
    """The trials of a campaign, in the scenarios in turns."""
    return [
        OperatorTrial(
            SCENARIOS[i % len(SCENARIOS)],
            seed + i,
            60.0 * minutes,
            str(folder / f"operator_{seed + i:02d}"),
        )
        for i in range(count)
    ]


def run_operator(trial: OperatorTrial) -> OperatorResult:
    """Runs one operator and judges the session; it stays in its folder.

    A session that is there already was broken off, and is begun again.
    """
    start = perf_counter()
    folder = Path(trial.folder)
    if folder.exists():
        shutil.rmtree(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    scenario = load_scenario(trial.scenario, trial.text)
    world = load_world(scenario, blank=True)
    run = operate(scenario, world, folder, trial.seed, trial.duration)
    result = dc.replace(
        judge(folder),
        key=trial.key,
        scenario=trial.scenario,
        seed=trial.seed,
        stops=run.stops,
        stopped=run.stopped,
    )
    return dc.replace(result, wall=perf_counter() - start)


def crashed(trial: OperatorTrial, error: str) -> OperatorResult:
    """The result of a trial that failed."""
    return OperatorResult(trial.key, trial.scenario, trial.seed, error=error)
