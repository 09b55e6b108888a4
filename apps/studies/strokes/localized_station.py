"""`LocalizedStation`: a simulated robot that is localised as a real one is.

The base's pose on its ports comes from the messages of an odometry and of a
localisation, with their noise, delays and drift, and from the filter that fuses
them for a real robot.
"""

import copy
import dataclasses as dc
from typing import Annotated

import numpy as np
from annotated_types import Interval
from pydrake.common.value import Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    Diagram,
    DiagramBuilder,
    LeafSystem,
    State,
)

from remosplat_drake.app.identification.reading import Reading, reading_of
from remosplat_drake.base.clock import MICROSECONDS
from remosplat_drake.base.ranges import Config
from remosplat_drake.hardware.client.base_track import (
    track_problem,
    with_localization,
)
from remosplat_drake.hardware.client.measurement import (
    Measurement,
    with_base_status,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.localization_config import LocalizationConfig
from remosplat_drake.hardware.stand_in.base_senses import BaseSenses
from remosplat_drake.hardware.stand_in.faults import Fault, FaultSchedule
from remosplat_drake.hardware.stand_in.simulated_base import SimulatedBase
from remosplat_drake.hardware.wire.base import base_axes
from remosplat_drake.hardware.wire.panda import PandaState
from remosplat_drake.robot.planar_pose import relative
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.signals.station_status import STOPPED, StationStatus
from remosplat_drake.station.simulated_station import MakeSimulatedStation
from remosplat_drake.station.station_camera import StationCamera
from remosplat_drake.station.station_config import KinematicStation

TRUE_POSE = f"{ports.CHEAT}base_pose"
"""Name of the output with the base's true pose in W."""

BASE_ERROR = f"{ports.CHEAT}base_error"
"""Name of the output with the error of the latest measured pose of the base, as
distance and angle [m, rad]."""

_SETTLED = 3.0
"""Time at rest before the simulation begins [s]."""

_PERIOD = 0.01
"""Time between two checks for new messages [s]."""

_DRIFT = 0.001
"""Rate at which the odometry drifts [m/s]."""

_FAR = 5.0
"""The odometry's origin has coordinates in W of at most this magnitude [m]."""

_NO_MODE, _ALL_CAME = 2, 1.0
"""Mode and success rate of an arm that follows commands."""


class LocalizedBase:
    """A base's messages, and the pose that a controller derives from them.

    Attributes:
        config: The settings of a localised robot.
        measurement: The latest states of the base.
        time: Time of the latest step, by the robot's clock [s].
        X_WB: True pose of the base at the latest measurement of its pose, shape
            (3,) [m, m, rad].
    """

    def __init__(self, X_WB: np.ndarray, seed: int):
        """Lets the base stand until its localisation has settled.

        Args:
            X_WB: True pose of the base, shape (3,) [m, m, rad].
            seed: Seed of the odometry's frame and of the noise.
        """
        random = np.random.default_rng(seed)
        most = np.array([_FAR, _FAR, np.pi])
        self.config = HardwareConfig(localization=LocalizationConfig())
        self.measurement, self.time, self.X_WB = Measurement(), 0.0, X_WB
        self._base = SimulatedBase()
        self._senses = BaseSenses(True, random.uniform(-most, most), seed)
        self._faults = FaultSchedule()
        self._faults.begin(Fault("base-drift", _DRIFT))
        for _ in range(round(_SETTLED / _PERIOD)):
            self.step(X_WB, np.zeros(3))

    def step(self, X_WB: np.ndarray, velocity: np.ndarray) -> None:
        """Advances the clock by one period, and receives what is sent then.

        Args:
            X_WB: True pose of the base, shape (3,) [m, m, rad].
            velocity: True speeds forward and to the left, and turning rate,
                shape (3,) [m/s, m/s, rad/s].
        """
        self.time += _PERIOD
        t, now = self.time, round(self.time * MICROSECONDS)
        self._senses.advance(t, self._faults)
        status = self._base.status(now, t, X_WB, velocity)
        if status is not None:
            self.X_WB = X_WB
            self._senses.spoil(status, self._faults)
            self.measurement = with_base_status(
                self.measurement, status.encode(), t, self.config
            )
        fix = self._senses.fix(now, t, X_WB, self._faults)
        if fix is not None:
            track = with_localization(self.measurement.base_track, fix, t)
            self.measurement = dc.replace(self.measurement, base_track=track)

    @property
    def error(self) -> np.ndarray:
        """Error of the latest measured pose in W, shape (2,) [m, rad].

        The pose is compared with the true pose at the time of its measurement.
        """
        assert self.measurement.base is not None
        told = self.measurement.base_track.pose(self.measurement.base.pose)
        x, y, turn = relative(self.X_WB, told)
        return np.array([np.hypot(x, y), abs(turn)])

    def reading(self, arm: np.ndarray, robot: RobotModel) -> Reading:
        """Returns what `remosplat identify` reads of the robot at rest.

        Args:
            arm: Positions of the arm's joints, shape (n,) [rad].
            robot: The robot.
        """
        state = PandaState(
            arm, np.zeros(len(arm)), self.time, self.time, _NO_MODE, _ALL_CAME
        )
        return reading_of(dc.replace(self.measurement, arm=state), robot)


class BaseLocalizer(LeafSystem):
    """Replaces a base's true pose and speeds by those from its messages.

    .. pydrake_system::

        name: BaseLocalizer
        input_ports:
        - pose
        - velocity
        - station_status
        output_ports:
        - base.pose_measured
        - base.velocity_measured
        - status
        - cheat.base_error

    As at the station of a real robot, the pose is extrapolated to the present
    by the measured speeds, and `status` contains the time of the extrapolation.

    Args:
        base: The base, standing at its start; the system moves a copy of it.
        n_base: Number of the base's commands.
    """

    def __init__(self, base: LocalizedBase, n_base: int):
        super().__init__()
        self.set_name("base_localizer")
        self._base, self._axes = copy.deepcopy(base), base_axes(n_base)
        # Messages come between two ticks, so that is when the clock advances.
        self._start = base.time + 0.5 * _PERIOD
        self._pose = self.DeclareVectorInputPort("pose", 3)
        self._velocity = self.DeclareVectorInputPort("velocity", n_base)
        self._status = self.DeclareAbstractInputPort(
            "station_status", Value(StationStatus())
        )
        self._cell = self.DeclareAbstractState(Value(base.measurement))
        error = self.DeclareDiscreteState(base.error)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            _PERIOD, 0.5 * _PERIOD, self._receive
        )
        known = {self.abstract_state_ticket(self._cell), self.time_ticket()}
        self.DeclareVectorOutputPort(ports.BASE_POSE, 3, self._calc_pose, known)
        self.DeclareVectorOutputPort(
            ports.BASE_VELOCITY,
            n_base,
            self._calc_velocity,
            {self.abstract_state_ticket(self._cell)},
        )
        self.DeclareStateOutputPort(BASE_ERROR, error)
        self.DeclareAbstractOutputPort(
            ports.STATUS,
            lambda: Value(StationStatus()),
            self._calc_status,
            {*known, self._status.ticket()},
        )

    def _receive(self, context: Context, state: State) -> None:
        velocity = np.zeros(3)
        velocity[self._axes] = self._velocity.Eval(context)
        self._base.step(np.array(self._pose.Eval(context)), velocity)
        cell = state.get_mutable_abstract_state(int(self._cell))
        cell.set_value(self._base.measurement)
        state.get_mutable_discrete_state(0).set_value(self._base.error)

    def _known(self, context: Context) -> Measurement:
        return context.get_abstract_state(int(self._cell)).get_value()

    def _now(self, context: Context) -> tuple[float, float]:
        """The present time, and the longest time of extrapolation [s]."""
        now = self._start + context.get_time()
        return now, self._base.config.base_status_expiry

    def _calc_pose(self, context: Context, output: BasicVector) -> None:
        pose = self._known(context).base_pose(*self._now(context))
        output.SetFromVector(pose)

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        base = self._known(context).base
        assert base is not None
        output.SetFromVector(base.velocity[self._axes])

    def _calc_status(self, context: Context, output: Value) -> None:
        known = self._known(context)
        track = known.base_track
        status = dc.replace(
            self._status.Eval(context),
            base_age=known.base_age(*self._now(context)),
            base_uncertainty=tuple(track.uncertainty),
        )
        problem = track_problem(track, self._base.config)
        if problem:
            status = dc.replace(
                status, mode=STOPPED, stop_reason=problem, is_lost=True
            )
        output.set_value(status)


@dc.dataclass
class LocalizedStation(Config):
    """The kinematic station, with a base that is localised."""

    # Seed of the odometry's frame and of the noise.
    seed: Annotated[int, Interval(ge=0, le=2**62)] = 0

    def base(self, X_WB: np.ndarray) -> LocalizedBase:
        """Returns the base at rest, as at the start of the simulation.

        Args:
            X_WB: True pose of the base, shape (3,) [m, m, rad].
        """
        return LocalizedBase(X_WB, self.seed)

    def make(
        self,
        robot: RobotModel,
        scene: PrimitiveScene | None,
        q0: np.ndarray,
        camera: StationCamera | None,
    ) -> Diagram:
        """Builds the station; see `StationMaker`."""
        builder = DiagramBuilder()
        inner = builder.AddSystem(
            MakeSimulatedStation(
                config=KinematicStation(),
                robot=robot,
                scene=scene,
                q0=q0,
                wrist_camera=camera,
            )
        )
        localizer = builder.AddSystem(
            BaseLocalizer(self.base(q0[:3]), robot.n_base)
        )
        for source, sink in (
            (ports.BASE_POSE, "pose"),
            (ports.BASE_VELOCITY, "velocity"),
            (ports.STATUS, "station_status"),
        ):
            builder.Connect(
                inner.GetOutputPort(source), localizer.GetInputPort(sink)
            )
        builder.ExportOutput(inner.GetOutputPort(ports.BASE_POSE), TRUE_POSE)
        builder.ExportOutput(localizer.GetOutputPort(BASE_ERROR), BASE_ERROR)
        for i in range(inner.num_input_ports()):
            port = inner.get_input_port(i)
            builder.ExportInput(port, port.get_name())
        for i in range(inner.num_output_ports()):
            name = inner.get_output_port(i).get_name()
            system = localizer if localizer.HasOutputPort(name) else inner
            builder.ExportOutput(system.GetOutputPort(name), name)
        station = builder.Build()
        station.set_name("station")
        return station
