"""Groups the results of many trials into comparable rows."""

import dataclasses as dc
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.strict_yaml import entries
from remosplat_drake.benchmark import motion_bench_maker, robot_suite
from remosplat_drake.benchmark.methods import METHODS_FILE
from remosplat_drake.benchmark.paper_results import (
    PAPER_SCANS,
    PAPER_TABLE_I,
    PaperRow,
)
from remosplat_drake.benchmark.result import (
    COLLISION,
    CRASH,
    OUTCOMES,
    RULES,
    TrialResult,
)


@dc.dataclass(frozen=True, eq=False)
class Row:
    """One row of a table: all trials of a method with the same settings.

    Attributes:
        method: Name of the method.
        spheres: Sphere set of the robot.
        gains: Gain set of the controller.
        splat: Origin of the splats: "none", "trained", "surfel", or several
            joined by "+".
        station: Kind of the station: "kinematic" or "dynamic".
        trials: Results of the trials, sorted by scene.
    """

    method: str
    spheres: str
    gains: str
    splat: str
    station: str
    trials: tuple[TrialResult, ...]

    def __len__(self) -> int:
        return len(self.trials)

    @property
    def scenes(self) -> tuple[tuple[str, int], ...]:
        """Names and seeds of the scenes that were run."""
        return tuple((t.scene, t.seed) for t in self.trials)

    @property
    def splat_label(self) -> str:
        """Origin of the splats, and their mean number."""
        if self.splat == "none":
            return "–"
        counts = [t.splat_count for t in self.trials if t.splat_count]
        return f"{self.splat}, {np.mean(counts) / 1e3:.0f}k"

    def successes(self, rule: str) -> np.ndarray:
        """Returns which trials succeeded by one of `RULES`, shape (n,) bool."""
        return np.array([t.success(rule) for t in self.trials], bool)

    def count(self, outcome: str, rule: str) -> int:
        """Counts the trials that have a given outcome by one of `RULES`."""
        return sum(t.outcome(rule) == outcome for t in self.trials)

    def collisions(self) -> int:
        """Returns the number of trials with a collision by any of `RULES`."""
        return sum(
            any(t.outcome(rule) == COLLISION for rule in RULES)
            for t in self.trials
        )

    def values(self, field: str, rule: str, chosen: np.ndarray) -> np.ndarray:
        """Returns a field of `Judgement` over the trials that did not crash.

        Args:
            field: Name of the field.
            rule: One of the success rules in `RULES`.
            chosen: Mask of the trials to use, shape (n,) bool.

        Returns:
            One value for each chosen trial that did not crash, NaN if it is
            unknown.
        """
        judged = [self.trials[i].judged(rule) for i in np.flatnonzero(chosen)]
        found = [getattr(j, field) for j in judged if j is not None]
        return np.array(found, float)

    def times(self, field: str) -> np.ndarray:
        """Returns a field of `WallTimes` over all trials that did not crash."""
        times = [t.times for t in self.trials if t.times is not None]
        return np.array([getattr(t, field) for t in times])


@dc.dataclass(frozen=True, eq=False)
class Comparison:
    """Rows of several methods with the same scenes, sphere set and station.

    Attributes:
        rows: Rows of the methods, in the order of `gather`.
    """

    rows: tuple[Row, ...]

    @property
    def is_scan(self) -> bool:
        """Whether the scenes repeat the paper's experiment 2 or 3."""
        return set(self.families()) <= set(PAPER_SCANS)

    @property
    def is_moving(self) -> bool:
        """Whether the scenes contain movers."""
        return any(t.moving for row in self.rows for t in row.trials)

    @property
    def is_carrying(self) -> bool:
        """Whether the robot carries an object back."""
        return any(t.carrying for row in self.rows for t in row.trials)

    @property
    def is_motion(self) -> bool:
        """Whether the scenes are MotionBenchMaker's problems."""
        return self.suite.startswith(motion_bench_maker.SUITE)

    @property
    def is_robots(self) -> bool:
        """Whether the scenes are of the suite of random targets (`robots`)."""
        return self.suite == robot_suite.SUITE

    @property
    def paper(self) -> dict[str, PaperRow]:
        """Rows of the paper's Table I for these methods, keyed by our names."""
        ours = self.is_scan or self.is_motion or self.is_robots
        return {} if ours or self.is_moving else PAPER_TABLE_I

    def common(self, rule: str) -> np.ndarray:
        """Returns whether each scene is solved in all rows, (n,) bool."""
        return np.logical_and.reduce([r.successes(rule) for r in self.rows])

    @property
    def suite(self) -> str:
        """Name of the suite of the scenes."""
        return self.rows[0].trials[0].suite

    @property
    def title(self) -> str:
        """Title with the numbers of scenes, spheres and the station."""
        first = self.rows[0]
        families = ", ".join(
            f"{sum(t.family == family for t in first.trials)} {family}"
            for family in self.families()
        )
        return (
            f"{self.suite + ': ' if self.suite else ''}{families};"
            f" {first.spheres} spheres, {first.station} station"
        )

    def families(self) -> list[str]:
        """Returns the families of the scenes, in alphabetical order."""
        return sorted({t.family for t in self.rows[0].trials})

    def outcomes(self) -> list[str]:
        """Returns the outcomes that occur, except success and collision."""
        seen = {
            t.outcome(rule)
            for row in self.rows
            for t in row.trials
            for rule in RULES
        }
        return [o for o in OUTCOMES[1:] if o in seen and o != COLLISION]


def gather(results: Sequence[TrialResult]) -> list[Comparison]:
    """Groups results into rows, and rows into comparisons.

    If a scene has several results with the same method, spheres and station,
    for example with different splats, the last one counts. The rows are in the
    order of the shipped file of methods, followed by other methods by name.
    """
    by_setup = defaultdict(dict)
    for result in results:
        setup = (
            result.method,
            result.suite,
            result.spheres,
            result.gains,
            result.station,
        )
        scene = (result.family, result.scene, result.seed)
        by_setup[setup][scene] = result
    by_scenes = defaultdict(list)
    shipped = entries(METHODS_FILE)

    def place(setup: tuple[str, ...]) -> tuple:
        known = setup[0] in shipped
        return (shipped.index(setup[0]) if known else len(shipped), setup)

    for setup in sorted(by_setup, key=place):
        method, suite, spheres, gains, station = setup
        trials = sorted(
            by_setup[setup].values(), key=lambda t: (t.family, t.scene, t.seed)
        )
        origins = {t.splat for t in trials if t.outcome(RULES[0]) != CRASH}
        row = Row(
            method,
            spheres,
            gains,
            "+".join(sorted(origins)) or "none",
            station,
            tuple(trials),
        )
        by_scenes[suite, row.scenes, spheres, station].append(row)
    return [Comparison(tuple(rows)) for rows in by_scenes.values()]
