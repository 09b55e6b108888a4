"""`HardwareSim`: a simulated robot with the LCM messages of a real one."""

import copy
from collections import deque
from collections.abc import Callable, Iterator, Sequence

import numpy as np
from drake import lcmt_panda_status
from pydrake.lcm import DrakeLcmInterface

from remosplat_drake.base.clock import MICROSECONDS, wall_utime
from remosplat_drake.hardware.drivers.panda_commands import JOINTS
from remosplat_drake.hardware.drivers.panda_limits import TICK
from remosplat_drake.hardware.stand_in import faults
from remosplat_drake.hardware.stand_in.actuated_axes import ActuatedAxes
from remosplat_drake.hardware.stand_in.base_senses import BaseSenses
from remosplat_drake.hardware.stand_in.faults import Fault, FaultSchedule
from remosplat_drake.hardware.stand_in.fci_arm import FciArm
from remosplat_drake.hardware.stand_in.robot_plant import RobotPlant
from remosplat_drake.hardware.stand_in.rtde_arm import RtdeArm
from remosplat_drake.hardware.stand_in.simulated_arm import (
    ArmLimits,
    RobotMode,
    SimulatedArm,
)
from remosplat_drake.hardware.stand_in.simulated_base import SimulatedBase
from remosplat_drake.hardware.stand_in.simulated_hand import SimulatedHand
from remosplat_drake.hardware.stand_in.simulated_panda import SimulatedPanda
from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.base import base_axes
from remosplat_drake.hardware.wire.hand import check_hands
from remosplat_drake.hardware.wire.inbox import CommandSource, Inbox
from remosplat_drake.hardware.wire.packets import stamp_of
from remosplat_drake.robot.actuators import Actuator, panda_py_actuators
from remosplat_drake.robot.robot_description import RobotDescription
from remosplat_drake.robot.robot_model import RobotModel


def commanded(
    description: RobotDescription, has_arm_driver: bool = False
) -> list[str]:
    """Returns the channels of a robot's commands.

    Args:
        description: The robot.
        has_arm_driver: Whether a separate driver commands the arm.
    """
    heard = [channels.COMMAND_RAMP]
    if not has_arm_driver:
        heard.append(channels.PANDA_COMMAND)
    if description.base:
        heard.append(channels.BASE_COMMAND)
    if description.hand:
        heard.append(channels.PANDA_HAND_COMMAND)
    return heard


_PANDA = "panda"
"""Name of the arms that libfranka drives."""

_SPARSE = 4
"""While the simulated robot catches up after a delay, it sends only every n-th
status of the arm, where n is this value.
"""


class HardwareSim:
    """A simulated robot with its drivers, in 1 ms steps.

    A Panda is driven by libfranka's law. Other arms follow commands within
    their bounds on acceleration. If the robot has no base or no hand, no
    messages of this part are sent.

    The order within a step is that of the real control loop: receive commands,
    decide, move, publish statuses.

    Attributes:
        arm: The arm and its driver.
        base: The mobile base and its driver.
        hand: The gripper and its driver.
    """

    def __init__(
        self,
        plant: RobotPlant,
        lcm: DrakeLcmInterface,
        schedule: Sequence[Fault] = (),
        clock: Callable[[], int] = wall_utime,
        *,
        actuators: Sequence[Actuator] = (),
        fci: FciArm | RtdeArm | None = None,
        localizes: bool = False,
        status_rate: float = 1.0 / TICK,
        inbox: CommandSource | None = None,
    ):
        """Subscribes; nothing is sent before the first step.

        Args:
            plant: The robot's rigid bodies and motors.
            lcm: The LCM network.
            schedule: The scheduled faults.
            clock: Function that returns the wall clock of the robot's computer
                [us].
            actuators: Models of how base and arm follow their drivers'
                commands, in the order of u. If empty, they follow without
                delay.
            fci: The arm's interface to a separate driver process; None
                simulates the driver, too.
            localizes: Whether a localisation of the base is simulated. If so,
                the odometry starts at another pose.
            status_rate: Rate of the arm's statuses [Hz].
            inbox: Source of commands and of requests for faults; None accepts
                every sender.

        Raises:
            FieldError: The robot has several hands.
        """
        check_hands(plant.robot.description)
        self._plant = plant
        self._lcm = lcm
        self._clock = clock
        self._robot = plant.robot
        description = self._robot.description
        heard = [*commanded(description, fci is not None), faults.CHANNEL]
        self._inbox = inbox or Inbox(lcm, heard)
        self._unheard: deque[tuple[str, bytes]] = deque()
        self._faults = FaultSchedule(schedule)
        self.arm = _make_arm(self._robot)
        self._fci = fci
        self.base = SimulatedBase(self._robot.is_omnidirectional)
        self._base_axes = base_axes(self._robot.n_base)
        self._senses = BaseSenses(localizes)
        self.hand = SimulatedHand(plant.hand[0])
        self._described = list(actuators)
        self._slow = (0.0, False)
        self._axes = ActuatedAxes(actuators, TICK) if actuators else None
        self._late_arm: deque[tuple[float, bytes]] = deque()
        self._late_base: deque[tuple[float, bytes]] = deque()
        self._status_period, self._next_status = 1.0 / status_rate, 0.0
        self._measured = plant.arm
        self._ticks = 0
        self._is_late, self._stamp = False, clock()
        self._first_command: float | None = None
        self._frozen = lcmt_panda_status()

    @property
    def time(self) -> float:
        """The robot's own clock, which starts at 0 [s]."""
        return self._ticks * TICK

    def step(self, late: float = 0.0) -> None:
        """Runs one millisecond of the robot.

        A real robot continues while this computer stalls. So after a stall, the
        caller runs the missing steps quickly. The stamp of each step is the
        time at which the step was due, and the step processes only the commands
        that were sent before its stamp. Fewer statuses of the arm are sent
        during these steps.

        Args:
            late: Delay of this millisecond, by the wall clock [s].
        """
        self._is_late = late > TICK
        self._stamp = self._clock() - round(late * MICROSECONDS)
        t = self.time
        self._hear(t)
        self._break(t)
        now = self._now()
        n = self._robot.n_base
        base = self.base.step(now, t, TICK)[self._base_axes]
        if self._fci is None:
            arm = self.arm.step(now, self._measured)
        else:
            arm = self._fci.step(self._measured)
        self._change_actuators()
        if self._axes is not None:
            velocity = self._axes.step(np.concatenate([base, arm]))
            base, arm = velocity[:n], velocity[n:]
        self._ticks += 1
        hand = self.hand.command
        if "hand-opens" in self._faults:
            hand = np.array([np.inf, hand[1]])
        self._plant.step(self.time, base, arm, hand)
        self._measured = self._plant.arm
        self._tell(self.time)

    def _change_actuators(self) -> None:
        """Replaces the actuators during faults that change them."""
        late = self._faults.value("base-command-delay", 0.0)
        slow = late, "panda-py" in self._faults
        if slow == self._slow:
            return
        self._slow = slow
        n = self._robot.n_base
        actuators = self._described or [Actuator()] * self._robot.n_u
        base = [Actuator(delay=late)] * n if late else actuators[:n]
        arm = panda_py_actuators() if slow[1] else actuators[n:]
        self._axes = ActuatedAxes([*base, *arm], TICK)

    def _now(self) -> int:
        """The wall clock of the robot's computer, with its error [us]."""
        jump = self._faults.value("clock-jump", 0.0)
        return self._stamp + round(jump * MICROSECONDS)

    def _hear(self, t: float) -> None:
        for channel, data in self._fetch():
            if channel == faults.CHANNEL:
                for fault in faults.requested_faults(data):
                    self._faults.begin(fault)
                    self._trip(fault, t)
                continue
            if channel == channels.COMMAND_RAMP:
                self.arm.commands.hear(channel, data)
                self.base.commands.hear(channel, data, t)
                continue
            if channel == channels.PANDA_COMMAND:
                self.arm.commands.receive(data)
            elif channel == channels.BASE_COMMAND:
                self.base.commands.receive(data, t)
            else:
                self.hand.receive(data)
            if self._first_command is None:
                self._first_command = t

    def _fetch(self) -> Iterator[tuple[str, bytes]]:
        """Yields the messages that were sent before the robot's time."""
        self._unheard.extend(self._inbox.fetch())
        while self._unheard and not self._is_ahead(self._unheard[0][1]):
            yield self._unheard.popleft()

    def _is_ahead(self, data: bytes) -> bool:
        """Whether a message was sent after the stamp of the present step."""
        if not self._is_late:
            return False
        stamp = stamp_of(data)
        return stamp is not None and self._stamp < stamp <= self._clock()

    def _break(self, t: float) -> None:
        if self._first_command is not None:
            for fault in self._faults.advance(t - self._first_command):
                self._trip(fault, t)

    def _trip(self, fault: Fault, t: float) -> None:
        """Applies a fault that takes effect once."""
        arm = self._fci or self.arm
        if fault.name == "reflex":
            arm.stop(RobotMode.REFLEX)
        elif fault.name == "user-stop":
            arm.stop(RobotMode.USER_STOPPED)
        elif fault.name == "base-protective-stop":
            self.base.protective_stop(t)
        elif fault.name == "base-emergency-stop":
            self.base.emergency_stop = True
        elif fault.name == faults.RECOVER:
            arm.recover()
            self.base.recover()

    def _tell(self, t: float) -> None:
        now = self._now()
        if self._fci is None:
            self._tell_of_arm(now, t)
        if self._robot.n_base:
            self._tell_of_base(now, t)
        if self._robot.description.hand:
            hand = self.hand.status(now, t, self._plant.hand)
            if hand is not None and "hand-status-stops" not in self._faults:
                self._lcm.Publish(channels.PANDA_HAND_STATUS, hand.encode())

    def _tell_of_arm(self, now: int, t: float) -> None:
        is_sparse = self._is_late and self._ticks % _SPARSE != 0
        if t + 0.5 * TICK >= self._next_status and not is_sparse:
            self._next_status = max(self._next_status + self._status_period, t)
            if "status-stops" not in self._faults:
                late = self._faults.value("status-delay", 0.0)
                status = self._arm_status(now)
                self._late_arm.append((t + late, status.encode()))
        self._send_due(channels.PANDA_STATUS, self._late_arm, t)

    def _send_due(
        self, channel: str, waiting: deque[tuple[float, bytes]], t: float
    ) -> None:
        while waiting and waiting[0][0] <= t:
            self._lcm.Publish(channel, waiting.popleft()[1])

    def _tell_of_base(self, now: int, t: float) -> None:
        pose = self._plant.q[:3]
        self._senses.advance(t, self._faults)
        base = self.base.status(now, t, pose, self._plant.base_velocity)
        if base is not None and "base-status-stops" not in self._faults:
            self._senses.spoil(base, self._faults)
            late = self._faults.value("base-status-delay", 0.0)
            self._late_base.append((t + late, base.encode()))
        self._send_due(channels.BASE_STATUS, self._late_base, t)
        fix = self._senses.fix(now, t, pose, self._faults)
        if fix is not None:
            self._lcm.Publish(channels.BASE_LOCALIZATION, fix)

    def _arm_status(self, now: int) -> lcmt_panda_status:
        lost = self._faults.value("packet-loss", 0.0)
        self.arm.success_rate = 1.0 - lost
        status = self.arm.status(now, self._measured)
        if "status-freezes" not in self._faults:
            self._frozen = status
        else:
            status = copy.copy(self._frozen)
            status.utime = now
        faults.spoil(status, self._faults)
        return status


def _make_arm(robot: RobotModel) -> SimulatedArm:
    """Makes the arm's driver; that of a Panda has libfranka's law."""
    arm = slice(robot.n_q - len(robot.home), robot.n_q)
    rates = slice(robot.n_base, robot.n_u)
    limits = ArmLimits(
        robot.position_lower[arm],
        robot.position_upper[arm],
        robot.velocity_limit[rates],
        robot.acceleration_limit[rates],
    )
    if robot.description.arm.name == _PANDA and len(robot.home) == JOINTS:
        return SimulatedPanda()
    return SimulatedArm(limits)
