"""Measures errors of base and map while the base's odometry drifts."""

import dataclasses as dc
import time

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from apps.studies.live_map.session import LiveSession
from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.scenario_robot import load_scenario_robot
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.real_time import Spread
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.robot.planar_pose import relative
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests
from remosplat_drake.station.station_config import KinematicStation
from remosplat_drake.teleop.teleop_config import SavedPose

DRIFT = (0.012, 0.016, 0.0005)
"""Velocity of the odometry's frame: 2 cm/s and 0.5 mrad/s."""

_LOOK = 0.8
"""Rotation of the wrist from its home position [rad], so that the camera points
ahead and not at the floor below the hand."""

_PLACES = (
    (0.75, 0.0, 0.95, 0),
    (0.6, 0.4, 0.9, 25),
    (0.65, -0.4, 0.95, -20),
    (0.9, 0.1, 0.95, 10),
    (0.5, -0.2, 0.85, 0),
    (0.7, 0.3, 1.0, -30),
)
"""Saved poses of the operator: x, y, z [m], and the heading [deg]."""

_FRAMES = 12.0
"""Time between two frames that the operator requests [s]."""


@dc.dataclass(frozen=True)
class DriftErrors:
    """Errors during a session and at its end.

    Attributes:
        seconds: Time of the session [s].
        drift: Drift of the odometry at the end [m].
        base: Errors of the base's position in the map, at all ticks from the
            first map on [m].
        surfaces: Distances of the last map's discs from the true surfaces [m].
        versions: Number of the last map.
        tick: Wall-clock times of the ticks [s].
    """

    seconds: float
    drift: float
    base: Spread
    surfaces: Spread
    versions: int
    tick: Spread


def drifting(
    text: str = "", drift: tuple[float, float, float] = DRIFT
) -> Scenario:
    """Loads StudioLive with drifting odometry; makes an operator that scans.

    Args:
        text: YAML that overrides fields of the scenario.
        drift: Velocity of the odometry's frame [m/s, m/s, rad/s].
    """
    scenario = load_scenario("StudioLive", text)
    assert isinstance(scenario.station, KinematicStation)
    scenario.station.odometry_drift = list(drift)
    scenario.mapping.odometry_drift = 0.02
    scenario.mapping.odometry_turn = 0.002
    robot = load_scenario_robot(scenario)
    q = robot.q_home.copy()
    q[-2] += _LOOK
    scenario.robot.arm = q[3:].tolist()
    R_WE = RigidTransform(robot.state(q).X_WE).rotation()
    scenario.teleop.poses = {}
    for i, (*p_WT, heading) in enumerate(_PLACES):
        turn = RollPitchYaw(0, 0, np.deg2rad(heading)).ToRotationMatrix()
        rpy = RollPitchYaw(turn @ R_WE).vector()
        scenario.teleop.poses[f"place {i}"] = SavedPose(
            translation=list(p_WT), rpy_deg=np.rad2deg(rpy).tolist()
        )
    return scenario


def measure_drift(
    session: LiveSession,
    truth: PrimitiveScene,
    seconds: float,
    drift: tuple[float, float, float] = DRIFT,
) -> DriftErrors:
    """Drives from pose to pose, requests frames, and compares with the truth.

    Args:
        session: New session of the scenario that `drifting` has loaded.
        truth: The true scene.
        seconds: Time of the session [s].
        drift: Velocity of the odometry's frame [m/s, m/s, rad/s].

    Raises:
        RemoSplatError: There is no map at the end.
    """
    session.scan()
    asked, base, ticks = 0.0, [], []
    while session.time < seconds:
        start = time.perf_counter()
        session.tick()
        ticks.append(time.perf_counter() - start)
        if not session.status.swaps:
            continue
        session.move_on()
        if session.time - asked > _FRAMES:
            asked = session.time
            session.ask(MapRequests(frames=1))
        measured, q = session.configurations
        X_WB = measured[:3] - np.array(drift) * session.time
        base.append(np.hypot(*relative(X_WB, q[:3])[:2]))
    splat_W = session.status.scene_map.splat_W
    if splat_W is None or not len(splat_W):
        trouble = session.status.trouble or "too little was seen"
        raise RemoSplatError(f"there is no map: {trouble}")
    discs = Spheres.at(splat_W.p_GK.reshape(-1, 3).astype(float))
    apart = SignedDistanceField(truth).clearances(discs, np.inf).distance
    return DriftErrors(
        session.time,
        float(np.hypot(*drift[:2]) * session.time),
        Spread.of(np.array(base)),
        Spread.of(np.abs(apart)),
        session.status.scene_map.version,
        Spread.of(np.array(ticks)),
    )
