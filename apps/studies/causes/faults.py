"""`FaultyStation`: a simulated robot whose status shows a fault for a while.

For faults of the localisation, the station makes fixes, and the code for real
robots detects the fault.
"""

import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval
from pydrake.common.value import Value
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
    State,
)

from remosplat_drake.base.ranges import Config, OneOf
from remosplat_drake.hardware.client.base_track import (
    BaseTrack,
    track_problem,
    with_base_sample,
    with_localization,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.wire.base import BaseState
from remosplat_drake.hardware.wire.localization import (
    BaseFix,
    encode_localization,
)
from remosplat_drake.hardware.wire.messages.base_status import base_status
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import STOPPED, StationStatus
from remosplat_drake.station.export import export_ports
from remosplat_drake.station.kinematic_station import make_kinematic_station
from remosplat_drake.station.station_camera import StationCamera
from remosplat_drake.station.station_config import KinematicStation

MODE, SCANNER, LOST = "mode", "scanner", "localisation"
CLASSES = {
    MODE: ("reflex", "user_stopped", "late", "lossy"),
    SCANNER: ("scanner",),
    LOST: ("silence", "doubt", "frame"),
}
"""Names of the faults, keyed by their class."""

LASTS = 2.5
"""Duration of a fault [s]."""

STATUSES = {
    "reflex": StationStatus(robot_mode="reflex"),
    "user_stopped": StationStatus(robot_mode="user_stopped"),
    "late": StationStatus(age=0.2),
    "lossy": StationStatus(success_rate=0.3),
    "scanner": StationStatus(protective_stop=True),
}
"""The station's status during each fault, except for faults of the
localisation."""

_PERIOD = 0.03
"""Time between two fixes [s]."""

_CONFIG = HardwareConfig(localization=LocalizationConfig())
_GOOD = np.diag([1e-6, 1e-6, 1e-6])
_VAGUE = np.diag([0.1, 0.1, 0.1])


@dc.dataclass
class FaultyStation(Config):
    """A kinematic station whose status shows a fault for `LASTS`."""

    # The fault.
    fault: Annotated[
        str, OneOf(tuple(f for names in CLASSES.values() for f in names))
    ] = "reflex"
    # Time at which it begins [s].
    begin: Annotated[float, Interval(ge=0, le=100)] = 0.5

    def make(
        self,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        q0: np.ndarray,
        camera: StationCamera | None,
    ) -> Diagram:
        """Builds the station; see `StationMaker`."""
        builder = DiagramBuilder()
        inner = make_kinematic_station(
            KinematicStation(), robot, scene, q0, camera
        )
        builder.AddSystem(inner)
        status = builder.AddSystem(FaultyStatus(self))
        builder.Connect(
            inner.GetOutputPort(ports.BASE_POSE), status.GetInputPort("pose")
        )
        export_ports(builder, robot.description, [inner, status])
        station = builder.Build()
        station.set_name("station")
        return station


@dc.dataclass(frozen=True, eq=False)
class _Heard:
    """Track and path of the base; copying returns the object itself."""

    track: BaseTrack = dc.field(default_factory=BaseTrack)
    problem: str = ""
    pose: np.ndarray | None = None

    def __deepcopy__(self, memo) -> "_Heard":
        return self


class FaultyStatus(LeafSystem):
    """Outputs the status of a station with a fault.

    .. pydrake_system::

        name: FaultyStatus
        input_ports:
        - pose
        output_ports:
        - status

    Args:
        config: The fault and its time.
    """

    def __init__(self, config: FaultyStation):
        super().__init__()
        self.set_name("faulty_status")
        self._config = config
        self._pose_input = self.DeclareVectorInputPort("pose", 3)
        self._index = self.DeclareAbstractState(Value(_Heard()))
        self.DeclareAbstractOutputPort(
            ports.STATUS,
            Value(StationStatus()).Clone,
            self._calc_status,
            {self.time_ticket(), self.abstract_state_ticket(self._index)},
        )
        if config.fault in CLASSES[LOST]:
            self.DeclarePeriodicUnrestrictedUpdateEvent(
                _PERIOD, 0.0, self._hear
            )

    def _calc_status(self, context: Context, output: Value):
        heard = context.get_abstract_state(int(self._index)).get_value()
        is_on = has_fault(self._config, context.get_time())
        output.set_value(status_of(self._config.fault, is_on, heard.problem))

    def _hear(self, context: Context, state: State):
        time, cell = context.get_time(), int(self._index)
        before = context.get_abstract_state(cell).get_value()
        fault = self._config.fault if has_fault(self._config, time) else ""
        pose = self._pose_input.Eval(context)
        heard = _after(before, time, np.array(pose), fault)
        state.get_mutable_abstract_state(cell).set_value(heard)


def has_fault(config: FaultyStation, time: float) -> bool:
    """Returns whether the fault is present.

    Args:
        config: The fault and its time.
        time: The present time [s].
    """
    return config.begin <= time < config.begin + LASTS


def status_of(fault: str, is_on: bool, problem: str) -> StationStatus:
    """Returns the status of a station.

    Args:
        fault: The fault.
        is_on: Whether the fault is present.
        problem: The problem of the localisation; empty if there is none.
    """
    if problem:
        return StationStatus(mode=STOPPED, stop_reason=problem, is_lost=True)
    return STATUSES.get(fault, StationStatus()) if is_on else StationStatus()


def _after(before: _Heard, time: float, pose: np.ndarray, fault: str) -> _Heard:
    """Returns the track after odometry and a fix with the fault."""
    stamp = 1000.0 + time
    last = pose if before.pose is None else before.pose
    c, s = np.cos(pose[2]), np.sin(pose[2])
    x, y, turn = (pose - last) / _PERIOD
    velocity = np.array([c * x + s * y, c * y - s * x, turn])
    state = BaseState(
        pose, velocity, stamp, base_status.MOVING, False, False, 1.0
    )
    track = with_base_sample(before.track, state, stamp, None, _CONFIG)
    if fault != "silence":
        fix = BaseFix(
            pose,
            _VAGUE if fault == "doubt" else _GOOD,
            stamp,
            "elsewhere" if fault == "frame" else "map",
            "base_link",
        )
        track = with_localization(track, encode_localization(fix), stamp)
    return _Heard(track, track_problem(track, _CONFIG), pose)
