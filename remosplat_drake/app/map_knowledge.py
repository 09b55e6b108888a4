"""`MapKnowledge`: facts on a scenario's map, collected before a robot moves."""

import dataclasses as dc
from collections.abc import Mapping

import numpy as np

from remosplat_drake.app.scenario import Scenario
from remosplat_drake.app.scene_config import FREE, OBSTACLE, WARN
from remosplat_drake.app.world import World, scenario_targets
from remosplat_drake.base import resources
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.map_summary import (
    MapSummary,
    summarize_solids,
    summarize_splat,
)
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    GroundTruth,
    OracleMaker,
)
from remosplat_drake.reconstruction.report.quality_report import (
    DEPTH_VIEWS,
    ELLIPSOIDS,
    MAP_ERROR_MARGIN,
    QualityReport,
    read_report,
    remaining_of,
    report_path,
)
from remosplat_drake.robot.reach import arm_reach, shoulder
from remosplat_drake.safety.gates import (
    CAPTURE_WARNINGS,
    EMPTY_MAP,
    IGNORED_SPLATS,
    MAP_ERROR,
    REFUSAL,
    SILENCE,
    UNKNOWN_MAP_ERROR,
    UNKNOWN_SEEN_SPACE,
    UNSEEN_SPACE,
    WARNING,
    Gate,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat

MOST_OPACITY, MOST_SPLATS = 0.5, 0.75
"""In a good map, the oracle ignores at most these fractions of the opacity and
of the number of splats. The oracle ignores floaters, which are faint splats in
empty space. In our captures up to a third of the splats are floaters, but they
have only a thirtieth of the opacity."""

MOST_UNSEEN = 0.05
"""There is a warning if more than this fraction of the space around a robot's
path is unseen. The limit is not small, since the inside of objects is unseen,
too."""

_UNKNOWN = (
    "the map's error has not been measured; `remosplat quality` makes a"
    " report beside the splat"
)

_UNKNOWN_SPACE = (
    "it is not known which space the splat's cameras saw; `remosplat "
    "reconstruct` writes a file of this space beside the splat"
)

_ROUNDING = 1e-9  # Rounding error of distances in files [m].


@dc.dataclass(frozen=True)
class MapError:
    """The error of a map.

    Attributes:
        largest: Largest over-estimate of a distance [m]; None if it is unknown,
            or if the map is the true geometry.
        trouble: Reason why `largest` is unreliable; empty if it is reliable.
        warnings: Descriptions of defects of the map's capture.
    """

    largest: float | None = None
    trouble: str = ""
    warnings: tuple[str, ...] = ()


@dc.dataclass(frozen=True)
class MapKnowledge:
    """The content of a map, its error, and its problems for a scenario.

    Attributes:
        summary: Content of the map, in total and near the start and the
            targets.
        error: The error of the map.
        stopping: Smallest stopping distance that a run may use [m].
        gates: Problems of the map for this scenario.
        unseen: Fraction of the space between the start and the targets that no
            camera has seen; None if that is unknown.
        unseen_counts_as: Treatment of unseen space: `FREE` or `OBSTACLE`.
        unseen_places: Names of the places (start or targets) that lie in unseen
            space.
    """

    summary: MapSummary
    error: MapError
    stopping: float
    gates: tuple[Gate, ...]
    unseen: float | None = None
    unseen_counts_as: str = FREE
    unseen_places: tuple[str, ...] = ()

    def lines(self) -> tuple[str, ...]:
        """Describes the map in two or three lines."""
        error = "unknown" if self.error.trouble else "none"
        if self.error.largest is not None:
            error = f"up to {1e3 * self.error.largest:.1f} mm"
        return (
            f"map: {self.summary}",
            f"map error: {error}; smallest stopping distance:"
            f" {1e3 * self.stopping:.1f} mm",
            *self._unseen_line(),
        )

    def _unseen_line(self) -> list[str]:
        if self.unseen is None:
            return []
        return [
            f"unseen: {100 * self.unseen:.0f} % of the space between the start"
            f" and the targets; it counts as {self.unseen_counts_as}"
            + "".join(f"; {place} lies in it" for place in self.unseen_places)
        ]


def examine_map(
    scenario: Scenario, world: World, places: Mapping[str, np.ndarray]
) -> MapKnowledge:
    """Examines the map of a scenario.

    Args:
        scenario: A checked scenario.
        world: The content of the scenario's files, with a splat or a true
            scene.
        places: Target points of the end effector in W, keyed by name, shape
            (3,) each [m].
    """
    robot, truth = world.robot, world.truth
    places = {"the start": shoulder(robot, world.q0), **places}
    reach = arm_reach(robot)
    no_splat = world.splat_W is None
    if truth is not None and (
        no_splat or isinstance(scenario.oracle, GroundTruth)
    ):
        summary = summarize_solids(truth, places, reach)
    else:
        summary = summarize_splat(
            world.splat_W or GaussianSplat.empty(),
            world.cropped_W,
            scenario.oracle,
            places,
            reach=reach,
            floor_height=scenario.scene.floor_height,
        )
    error = find_map_error(scenario)
    unseen, hidden = None, ()
    if world.seen is not None:
        unseen = world.seen.unseen_fraction(places.values())
        hides = world.seen.hides(np.array(list(places.values())))
        hidden = tuple(np.array(list(places))[hides].tolist())
    return MapKnowledge(
        summary,
        error,
        scenario.controller.smallest_stopping,
        (
            *coverage_gates(summary),
            *map_error_gates(scenario, error),
            *unseen_gates(scenario, unseen),
        ),
        unseen,
        OBSTACLE if scenario.scene.unknown == OBSTACLE else FREE,
        hidden,
    )


def target_places(scenario: Scenario, world: World) -> dict[str, np.ndarray]:
    """Returns the points in W of a run's targets, keyed by name.

    Args:
        scenario: A checked scenario.
        world: The content of the scenario's files.

    Returns:
        The positions, keyed by names such as "target 1", shape (3,) each [m].
    """
    return {
        f"{name} target {i}".lstrip(): target.X_WT[:3, 3]
        for name, targets in scenario_targets(
            scenario, world.truth, world.robot.effectors
        ).items()
        for i, target in enumerate(targets, start=1)
    }


def saved_places(scenario: Scenario) -> dict[str, np.ndarray]:
    """Returns the points in W of an operator's saved poses, keyed by name.

    Args:
        scenario: A checked scenario.

    Returns:
        The positions of the saved poses, keyed by name, shape (3,) each [m].
    """
    return {
        f"pose {name!r}": np.array(pose.translation)
        for name, pose in scenario.teleop.poses.items()
    }


def coverage_gates(summary: MapSummary) -> list[Gate]:
    """Finds problems of a map's content.

    Args:
        summary: Content of the map, in total and near the start and the
            targets.
    """
    if not summary.kept:
        return [Gate(EMPTY_MAP, f"the map is empty: {summary}")]
    gates = []
    empty = [place.name for place in summary.places if not place.within_reach]
    if empty:
        problem = (
            f"the map has no data within {summary.reach:.1f} m of "
            f"{', '.join(empty)}; check scene.X_WG, scene.scale and scene.crop"
        )
        gates.append(Gate(EMPTY_MAP, problem))
    ignored = (
        summary.ignored > MOST_SPLATS or summary.ignored_opacity > MOST_OPACITY
    )
    # If all places are empty, the problem above suffices.
    if ignored and len(empty) < len(summary.places):
        problem = (
            f"{100 * summary.ignored:.0f} % of the splats within reach, with "
            f"{100 * summary.ignored_opacity:.0f} % of the opacity, are too "
            "faint or cropped away; check scene.crop and the oracle's opacity"
        )
        gates.append(Gate(IGNORED_SPLATS, problem))
    return gates


def map_error_gates(scenario: Scenario, error: MapError) -> list[Gate]:
    """Finds stopping distances that are too small for a map's error.

    Every stopping distance must exceed the map's error by `MAP_ERROR_MARGIN`.
    While the map's error is unknown, a stopping distance below the usual value
    is refused, even in simulation.

    Args:
        scenario: A checked scenario.
        error: The error of the map.
    """
    controller, gates = scenario.controller, []
    stopping, usual = (
        controller.smallest_stopping,
        controller.collision.stopping,
    )
    if error.trouble:
        level = WARNING if stopping == usual else REFUSAL
        gates.append(
            Gate(UNKNOWN_MAP_ERROR, error.trouble, in_simulation=level)
        )
    if error.warnings:
        gates.append(Gate(CAPTURE_WARNINGS, "; ".join(error.warnings)))
    if error.largest is None:
        return gates
    least = error.largest + MAP_ERROR_MARGIN
    if stopping < least - _ROUNDING:
        field = "collision.stopping" if stopping == usual else "guidance.tiers"
        problem = (
            f"controller.{field}: {stopping:g} is too small for a map that is"
            f" wrong by up to {error.largest:.4f}; valid: at least {least:.4f}"
        )
        gates.append(Gate(MAP_ERROR, problem, in_simulation=REFUSAL))
    for field, own in scenario.own_stopping.items():
        if own < least - _ROUNDING:
            problem = (
                f"{field}: {own:g} is too small for a map that is wrong by up"
                f" to {error.largest:.4f}; valid: at least {least:.4f}"
            )
            gates.append(Gate(MAP_ERROR, problem, in_simulation=REFUSAL))
    return gates


def remaining_error(report: QualityReport, oracle: OracleMaker) -> float:
    """Returns the map error that remains in an oracle's distances [m].

    Every stopping distance must exceed this error. It is smaller than the map's
    error if the oracle subtracts the uncertainty of each splat from the
    distances.

    Args:
        report: The measurements of the map.
        oracle: The oracle that uses the map.
    """
    looks = isinstance(oracle, DepthRasterization)
    remaining = remaining_of(report, DEPTH_VIEWS if looks else ELLIPSOIDS)
    subtracts = getattr(oracle, "uncertainty", "") == "subtract"
    if report.uncertainty and subtracts:
        return remaining
    return max(report.map_error, remaining)


def unseen_gates(scenario: Scenario, unseen: float | None) -> list[Gate]:
    """Finds problems that unseen space causes.

    Args:
        scenario: A checked scenario.
        unseen: Fraction of the space between the start and the targets that
            no camera has seen; None if that is unknown.
    """
    choice = scenario.scene.unknown
    if isinstance(scenario.oracle, GroundTruth) or not scenario.scene.splat:
        return []
    if unseen is None:
        level = {OBSTACLE: REFUSAL, WARN: WARNING}.get(choice or "", SILENCE)
        return [Gate(UNKNOWN_SEEN_SPACE, _UNKNOWN_SPACE, in_simulation=level)]
    if choice == OBSTACLE or not unseen:
        return []
    problem = (
        f"{100 * unseen:.0f} % of the space between the start and the targets"
        " is unseen and counts as free; scene.unknown: obstacle makes it solid"
    )
    told = choice != FREE and unseen > MOST_UNSEEN
    level = WARNING if told else SILENCE
    return [Gate(UNSEEN_SPACE, problem, in_simulation=level)]


def find_map_error(scenario: Scenario) -> MapError:
    """Finds the error of a scenario's map.

    It is the larger of two numbers: the scenario's `map_error`, and the error
    in the quality report beside the splat.

    Args:
        scenario: A checked scenario.
    """
    if isinstance(scenario.oracle, GroundTruth):
        return MapError()
    scene = scenario.scene
    splat = None
    if scene.splat:
        splat = resources.resolve(scene.splat, scenario.folder)
    if splat is None or not report_path(splat).is_file():
        if scene.map_error is None:
            return MapError(trouble=_UNKNOWN)
        return MapError(scene.map_error)
    try:
        report = read_report(splat)
        measured = remaining_error(report, scenario.oracle)
    except RemoSplatError as error:
        # The report is unreadable, and may describe a newer splat than the
        # scenario's `map_error`, so this value is not reliable.
        return MapError(scene.map_error, str(error))
    return MapError(
        max(measured, scene.map_error or 0.0),
        warnings=tuple(report.warnings),
    )
