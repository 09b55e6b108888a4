"""`RobotLink`: receives a robot's statuses, and sends commands, over LCM."""

import dataclasses as dc
import math
import time

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.base.ranges import check_ranges
from remosplat_drake.hardware.client.base_residual import CommandedPath
from remosplat_drake.hardware.client.base_track import (
    compile_kernels,
    with_localization,
)
from remosplat_drake.hardware.client.mailbox import Mailbox
from remosplat_drake.hardware.client.measurement import (
    Measurement,
    with_arm_status,
    with_base_status,
    with_hand_status,
)
from remosplat_drake.hardware.client.wire_guard import WireGuard
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.hardware.wire.base import (
    base_axes,
    base_velocity,
    encode_base_command,
)
from remosplat_drake.hardware.wire.command_limits import (
    command_bounds,
    excess,
    scaled_command,
)
from remosplat_drake.hardware.wire.hand import encode_hand_command
from remosplat_drake.hardware.wire.lease import LEASE_EXPIRY
from remosplat_drake.hardware.wire.panda import encode_panda_command
from remosplat_drake.hardware.wire.ramp import encode_ramp
from remosplat_drake.robot.braking import braking_time
from remosplat_drake.robot.robot_model import RobotModel

_MOVING = 0.02
"""If a commanded joint rate exceeds this value, the measured positions must
change [rad/s]."""

_BASE_AXES = (
    ("forward speed", "m/s"),
    ("speed to the left", "m/s"),
    ("yaw rate", "rad/s"),
)


class RobotLink:
    """The LCM connection to the drivers of one robot.

    It is independent of the diagram. So after an error in the diagram, the
    program can still use the link to bring the robot to rest.

    Attributes:
        lcm: The LCM network.
        guard: Monitor of other senders; None if the drivers are in this
            process.
        is_armed: Whether an operator has permitted motion. Until then, no
            commands are sent to the hand, either.
        arm: Mailbox of the arm's statuses.
        base: Mailbox of the base's statuses; None for a fixed robot.
        hand: Mailbox of the gripper's statuses; None for a robot without a
            gripper.
        localization: Mailbox of the base's localisation; None if none is
            configured.
        movers: Mailbox of movers; None if none is configured.
        commanded: The commands that were sent to the base so far.
        period: Control period [s], which is sent to the drivers together with
            the braking ramp. With None, no ramp is sent, and commands only
            expire.
        u: The latest command that was sent, shape (n_u,) [m/s, rad/s].
        sent: Time at which this command was sent, by our wall clock [s]; -inf
            before the first command.
    """

    def __init__(
        self,
        config: HardwareConfig,
        robot: RobotModel,
        *,
        name: str = "remosplat",
    ):
        """Subscribes to the drivers' statuses; nothing is sent.

        Args:
            config: LCM URL, channels, expiry times and the base's limits.
            robot: The robot.
            name: Name of this program, for display.

        Raises:
            FieldError: A value of the configuration is unusable.
        """
        self._config = config
        self._robot = robot
        check_ranges(config, field="hardware")
        self.lcm = config.open_lcm()
        description, names = robot.description, config.channels
        self.arm = Mailbox(self.lcm, names.arm_status)
        self.base = self.hand = self.localization = None
        if description.base:
            compile_kernels(config)
            self.base = Mailbox(self.lcm, names.base_status)
            if config.localization is not None:
                self.localization = Mailbox(self.lcm, names.localization)
        self.commanded = CommandedPath()
        self.movers = None
        if config.movers is not None:
            self.movers = Mailbox(self.lcm, names.movers)
        if description.hand:
            self.hand = Mailbox(self.lcm, names.hand_status)
        self.is_armed = True
        self.guard = None
        if not config.url.startswith("memq:"):
            self.guard = WireGuard(self.lcm, config, name)
        self.period: float | None = None
        self.u = np.zeros(robot.n_u)
        self.sent = -math.inf
        self._moving_since = math.inf
        self._hand_sent = -math.inf
        self._axes = base_axes(robot.n_base)
        lower, upper = config.base_bounds
        self._lower, self._upper = command_bounds(
            robot.n_u, lower[self._axes], upper[self._axes]
        )

    def take_out(self) -> None:
        """Empties Drake's subscriptions, so that they store newer packets."""
        self._hear(0)

    def _hear(self, milliseconds: int) -> None:
        """Waits for packets, and records their senders."""
        self.lcm.HandleSubscriptions(milliseconds)
        if self.guard is not None:
            self.guard.listen()

    def flush(self, timeout: float) -> bool:
        """Fetches the newest packets into the mailboxes.

        The packets in Drake's subscriptions arrived soon after the previous
        call, so they may be old. They are fetched first. If the arm's status
        among them is older than one period of its statuses, the function waits
        for the next status.

        Args:
            timeout: Longest wait for a status of the arm [s].

        Returns:
            Whether a status of the arm arrived within the timeout.
        """
        self.take_out()
        if 0 <= time.time() - self.arm.stamp < self._config.arm_status_period:
            return True
        count, deadline = self.arm.count, time.monotonic() + timeout
        while self.arm.count == count:
            left = deadline - time.monotonic()
            if left <= 0:
                return False
            self._hear(math.ceil(1e3 * left))
        return True

    def wait_for_statuses(self) -> None:
        """Waits for a new message of arm, base and all configured parts.

        Raises:
            RemoSplatError: No message came on a channel, which the error names.
        """
        self.take_out()
        silent = {
            box.channel: (box, box.count)
            for box in (self.arm, self.base, self.localization, self.movers)
            if box
        }
        deadline = time.monotonic() + self._config.connect_timeout
        while silent:
            if time.monotonic() > deadline:
                raise RemoSplatError(
                    f"no {' and no '.join(silent)} on {self._config.url}"
                    f" within {self._config.connect_timeout:g} s;"
                    " is the driver running?"
                )
            self._hear(50)
            silent = {
                channel: (box, count)
                for channel, (box, count) in silent.items()
                if box.count == count
            }

    def updated(self, measurement: Measurement) -> Measurement:
        """Updates a measurement with the packets that have arrived since."""
        n = len(self._robot.description.arm.joints)
        boxes = (self.arm, self.base, self.hand, self.localization)
        counts = tuple(box.count if box else 0 for box in boxes)
        intruder = self.guard.problem() if self.guard else ""
        known = (
            measurement.counts,
            measurement.moving_since,
            measurement.intruder,
            measurement.sent,
        )
        if known == (counts, self._moving_since, intruder, self.sent):
            return measurement
        for box, count, seen in zip(
            boxes, counts, measurement.counts, strict=True
        ):
            if box is None or box.data is None or count == seen:
                continue
            data, received = box.data, box.received
            if box is self.arm:
                measurement = with_arm_status(
                    measurement,
                    data,
                    received,
                    n,
                    self._config,
                    self._robot.velocity_limit[self._robot.n_base :],
                )
            elif box is self.base:
                measurement = with_base_status(
                    measurement, data, received, self._config, self.commanded
                )
            elif box is self.localization:
                track = with_localization(
                    measurement.base_track, data, received
                )
                measurement = dc.replace(measurement, base_track=track)
            else:
                measurement = with_hand_status(measurement, data)
        return dc.replace(
            measurement,
            counts=counts,
            moving_since=self._moving_since,
            intruder=intruder,
            sent=self.sent,
        )

    def command_problem(self, u: np.ndarray) -> str:
        """Returns the reason why a command must not be sent, or "".

        Args:
            u: Base and arm velocities, shape (n_u,) [m/s, rad/s].
        """
        found = excess(u, self._lower, self._upper)
        if found is None:
            return ""
        i, bound = found
        name, unit = _BASE_AXES[self._axes[i]]
        return (
            f"the base's {name} is commanded to be {u[i]:.3f} {unit}, beyond"
            f" {bound:.3f} {unit}"
        )

    def send(self, u: np.ndarray) -> None:
        """Sends a velocity command to base and arm, with the present time.

        Args:
            u: Velocities, shape (n_u,) [m/s, rad/s]. If they exceed the base's
                limits, all are scaled by one factor. If any is not finite,
                zeros are sent. Both are faults, which the station's status
                reports.
        """
        if not np.isfinite(u).all():
            u = np.zeros_like(u)
        u = scaled_command(u, self._lower, self._upper)
        n_base, names = self._robot.n_base, self._config.channels
        now = time.time()
        if self.period is not None:
            length = braking_time(u, self._robot.acceleration_limit)
            ramp = encode_ramp(now, self.period, length)
            self._publish(names.command_ramp, ramp)
        arm = encode_panda_command(u[n_base:], now)
        self._publish(names.arm_command, arm)
        if n_base:
            velocity = base_velocity(u[:n_base])
            base = encode_base_command(velocity, now)
            self._publish(names.base_command, base)
            # A shadow's commands move nothing.
            told = np.zeros(3) if self._config.shadow else velocity
            self.commanded.append(now, told)
        self.u, self.sent = u, now
        if not (np.abs(u[n_base:]) > _MOVING).any():
            self._moving_since = math.inf
        elif math.isinf(self._moving_since):
            self._moving_since = now

    def send_hand(self, width: float, force: float) -> None:
        """Sends a command to the gripper, at most once per `hand_period`.

        Args:
            width: Commanded opening [m].
            force: Bound on the gripping force [N].
        """
        now = time.time()
        is_due = now - self._hand_sent >= self._config.hand_period
        if is_due and self.is_armed:
            self._hand_sent = now
            self._publish(
                self._config.channels.hand_command,
                encode_hand_command(width, force, now),
            )

    def _publish(self, channel: str, data: bytes) -> None:
        """Sends a packet; in shadow mode, sends nothing."""
        if self._config.shadow:
            return
        self.lcm.Publish(channel, data)
        if self.guard is not None:
            self.guard.sent += 1

    def take_command(self) -> None:
        """Claims the drivers by a lease, when no other program commands them.

        Raises:
            RemoSplatError: Another program commands them, or two robots
                answer.
        """
        problem = self.guard.take_command(LEASE_EXPIRY) if self.guard else ""
        if problem:
            raise RemoSplatError(f"{self._config.url}: {problem}")

    def take_request(self) -> str:
        """Returns the operator that requested motion, or ""."""
        return self.guard.take_request() if self.guard else ""

    def tell(self, mode: str, reason: str) -> None:
        """Stores the supervisor's mode and reason for the next lease."""
        if self.guard is not None:
            self.guard.mode, self.guard.reason = mode, reason
