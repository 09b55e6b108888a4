"""Evaluates a session of teleoperation with the truth, at every tick.

mapped: surfaces that the frames of the map measured and that still exist.
scene: the whole scene, except new objects that no camera has seen. If unseen
    space is free, a robot may touch these, so they are counted separately.
"""

from pathlib import Path

import numpy as np

from apps.studies.operators.mapped_truth import MappedTruth
from apps.studies.operators.result import (
    KINDS,
    MAPPED,
    SCENE,
    UNSEEN,
    OperatorResult,
    Touch,
)
from remosplat_drake.app.recorded_run import RecordedRun, load_recorded_run
from remosplat_drake.app.scene_config import OBSTACLE
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.robot_model import RobotModel

_NEAR = 0.05
"""Distance beyond which nothing is measured [m]."""


def judge(folder: Path) -> OperatorResult:
    """Evaluates the latest run of a session with the truth.

    Raises:
        RemoSplatError: The session cannot be read.
    """
    run = load_recorded_run(folder)
    truth = _truth(run)
    clearance, deepest = _clearances(run, truth)
    # Objects that a frame shows do not count as unseen.
    fresh = np.where(clearance[SCENE] < 0, np.inf, clearance[UNSEEN])
    clearance[UNSEEN] = fresh
    touches = [
        touch
        for what in KINDS
        for touch in _touches(what, run, clearance[what], deepest[what])
    ]
    rows = run.log.rows
    known = rows["map_version"] > 0
    return OperatorResult(
        key="",
        scenario="",
        seed=0,
        careful=run.scenario.scene.unknown == OBSTACLE,
        ticks=len(rows),
        maps=int((np.diff(rows["map_version"]) != 0).sum()),
        frames=len(run.session.frames.names),
        scene_changes=len(run.scene_changes),
        map_clearance=float(rows["clearance"][known].min(initial=np.inf)),
        mapped_clearance=float(clearance[MAPPED].min()),
        true_clearance=float(clearance[SCENE].min()),
        touches=tuple(touches),
        path_length=_path_length(rows["q"], run.world.robot),
    )


def _truth(run: RecordedRun) -> MappedTruth:
    return MappedTruth(
        run.session,
        run.scenes,
        run.scene_changes,
        run.scenario.mapping.max_depth,
    )


def _clearances(
    run: RecordedRun, truth: MappedTruth
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Smallest distances at each tick (T,) [m], and the spheres' indices (T,).

    Distances above `_NEAR` count as infinite.
    """
    rows, robot = run.log.rows, run.world.robot
    distance = {what: np.full(len(rows), np.inf) for what in KINDS}
    sphere = {what: np.zeros(len(rows), int) for what in KINDS}
    for k, row in enumerate(rows):
        version = max(int(row["map_version"]), 0)
        changes = truth.changes_before(float(row["time"]))
        spheres = robot.spheres_at(row["q"])
        everything = SignedDistanceField(truth.scene(changes))
        near = np.unique(everything.clearances(spheres, _NEAR).sphere)
        if not len(near):
            continue
        few = spheres.select(near)
        for what, field in (
            (MAPPED, truth.surfaces(version, changes)),
            (SCENE, SignedDistanceField(truth.known(version, changes))),
            (UNSEEN, everything),
        ):
            found = field.clearances(few, _NEAR)
            if len(found):
                nearest = int(found.distance.argmin())
                distance[what][k] = found.distance[nearest]
                sphere[what][k] = near[found.sphere[nearest]]
    return distance, sphere


def _touches(
    what: str, run: RecordedRun, distance: np.ndarray, sphere: np.ndarray
) -> list[Touch]:
    """Returns the spans of ticks in which a distance is negative."""
    inside = np.concatenate([[False], distance < 0, [False]])
    starts, ends = np.flatnonzero(np.diff(inside)).reshape(-1, 2).T
    rows, robot = run.log.rows, run.world.robot
    touches = []
    for first, end in zip(starts, ends, strict=True):
        k = first + int(distance[first:end].argmin())
        spheres = robot.spheres_at(rows["q"][k])
        touches.append(
            Touch(
                what=what,
                start=float(rows["time"][first]),
                duration=float((end - first) * run.log.period),
                depth=float(-distance[k]),
                link=robot.spheres.links[sphere[k]],
                place=tuple(np.round(spheres.p_WS[sphere[k]], 3).tolist()),
                version=int(rows["map_version"][k]),
            )
        )
    return touches


def _path_length(q: np.ndarray, robot: RobotModel) -> float:
    p_WE = np.array([robot.end_effector_pose(each)[:3, 3] for each in q[::10]])
    return float(np.linalg.norm(np.diff(p_WE, axis=0), axis=1).sum())
