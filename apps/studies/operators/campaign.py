"""Runs simulated operators, and checks that no mapped surface is touched.

Each operator requests random targets at random times, also inside of furniture,
while the map changes. `RandomOperator` draws the requests, and `judge`
evaluates the run.
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
"""Scenarios that are operated, in turns."""

LATENCY = 3.0
"""Time from a request to the effect of its map [s]."""


@dc.dataclass(frozen=True)
class OperatorTrial:
    """One operator in one scenario.

    Attributes:
        scenario: Name of the scenario that is operated.
        seed: Seed of the operator.
        duration: Simulated time [s].
        folder: Folder that receives the session.
        text: YAML that overrides fields of the scenario.
    """

    scenario: str
    seed: int
    duration: float
    folder: str
    text: str = f"{{mapping: {{latency: {LATENCY}}}}}"

    @property
    def key(self) -> str:
        """Returns the key of the trial; trials of equal keys are equal."""
        return f"{self.scenario} seed {self.seed} {self.duration:g} s"


def make_trials(
    count: int, minutes: float, seed: int, folder: Path
) -> list[OperatorTrial]:
    """Makes the trials of a campaign, in the scenarios in turns.

    Args:
        count: Number of operators.
        minutes: Simulated time of each [min].
        seed: Seed of the first operator.
        folder: Folder that receives the sessions.
    """
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
    """Runs one operator and judges the session, which stays in its folder.

    An existing session was interrupted, and is started again.
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
    """Returns the result of a trial that failed with an error."""
    return OperatorResult(trial.key, trial.scenario, trial.seed, error=error)
