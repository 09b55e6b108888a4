"""`RobotModel`: a mobile manipulator, or a plain arm, for the controller.

Configuration q = (x, y, yaw, arm joints), command u = (v, omega, arm joint
rates): a differential base has three positions but two velocities. An
omnidirectional base has a third velocity, to the left, between these two. An
arm without a mobile base has neither base positions nor base velocities.
"""

import copy
import dataclasses as dc
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.base.ranges import joined
from remosplat_drake.base.reading import reads_file
from remosplat_drake.robot import kinematics as kin
from remosplat_drake.robot.actuators import Actuator, default_actuators
from remosplat_drake.robot.arm_dynamics import ArmDynamics
from remosplat_drake.robot.joint_limits import JointLimits
from remosplat_drake.robot.model_file import add_robot_model, find_frame
from remosplat_drake.robot.motion_bounds import hessian_bound, jacobian_bound
from remosplat_drake.robot.payload import Payload
from remosplat_drake.robot.robot_arrays import (
    RobotArrays,
    StateArrays,
    state_arrays,
)
from remosplat_drake.robot.robot_description import (
    RobotDescription,
    load_robot_description,
)
from remosplat_drake.robot.robot_state import RobotState
from remosplat_drake.robot.serial_chain import SerialChain
from remosplat_drake.robot.sphere_model import (
    SphereModel,
    Spheres,
    load_sphere_model,
)
from remosplat_drake.robot.sphere_tree import SphereTree

ROUNDING = 1e-3
"""An excess over a joint limit up to this value counts as rounding [rad, m]."""

_MOST_TURNED_BEYOND, _MOST_SLID_BEYOND = 0.5, 0.05
"""At the start, a joint may exceed its limits by at most this: the first number
is for revolute joints [rad], the second for prismatic joints [m]."""


class RobotModel:
    """Kinematics, limits and collision spheres of one robot.

    The object never changes after its creation; a deep copy is the object
    itself.

    Attributes:
        description: The robot description from which the model was made.
        spheres: The sphere model in use.
        payload: The object that the robot's hand carries, which is also a body
            of `tree`; None if it carries no object.
        tree: The kinematic tree, body 0 being the world.
        dynamics: The inverse dynamics.
        n_q: Number of configuration variables (10 for Frankie).
        n_u: Number of commanded velocities (9 for Frankie).
        n_base: Number of base commands: 3 (omnidirectional), 2 (differential)
            or 0 (fixed).
        effectors: Names of the end effectors; ("",) for a single end effector.
        velocity_limit: Symmetric bounds on u, shape (n_u,) [m/s, rad/s].
        acceleration_limit: Bounds on |du/dt|, shape (n_u,) [m/s^2, rad/s^2].
        jerk_limit: Bounds on |d2u/dt2|, shape (n_u,) [m/s^3, rad/s^3]; infinite
            where the description states none.
        position_lower: Lower joint limits of q, shape (n_q,) [m, rad]; infinite
            for the base.
        position_upper: Upper joint limits of q, shape (n_q,) [m, rad]; infinite
            for the base.
        fingers: Bodies of `tree` that are the hand's fingers, shape (f,).
        screw_body: Body of `tree` whose inboard joint each command moves, shape
            (n_u,); all base commands move the body that yaws.
        screw_turns: Whether each command rotates that body; otherwise it
            translates it, shape (n_u,), bool.

    Example:
        >>> import remosplat_drake as rs
        >>> robot = rs.load_robot("frankie")
        >>> X_WE = robot.end_effector_pose(robot.q_home)
        >>> X_WE.shape
        (4, 4)
    """

    def __init__(
        self,
        description: RobotDescription,
        spheres: SphereModel,
        floor_height: float = -np.inf,
    ):
        """Reads the kinematics from a plant, which is not kept.

        Args:
            description: The robot description.
            spheres: The robot's collision geometry; every link must exist.
            floor_height: Spheres of the description's floor links ignore scene
                points below this height [m].

        Raises:
            RemoSplatError: The description does not fit its model file.
        """
        self.description = description
        self.payload: Payload | None = None
        self._empty: RobotModel | None = None
        self._described: RobotModel | None = None
        self._floor_height = floor_height
        plant = MultibodyPlant(time_step=0.0)
        add_robot_model(description, plant)
        plant.Finalize()

        base_joints = description.base.joints if description.base else []
        self.joint_names = [*base_joints, *description.arm.joints]
        self.n_base = description.n_base
        self.n_q = len(self.joint_names)
        self.n_u = self.n_base + len(description.arm.joints)
        self._base_q = len(base_joints)
        self.tree = kin.make_kinematic_tree(
            plant, self.joint_names, description.locked
        )
        self.dynamics = ArmDynamics.read(
            plant, self.tree, base_joints, description.arm.joints
        )
        self._check_allowed_collisions()
        limits = JointLimits.read(description, plant)
        self.velocity_limit = limits.velocity
        self.acceleration_limit = limits.acceleration
        self.jerk_limit = limits.jerk
        self.position_lower, self.position_upper = limits.lower, limits.upper
        self._set_spheres(spheres)
        self._set_end_effectors(plant)
        self._set_fingers(plant)
        self._set_screws()

    def __deepcopy__(self, memo) -> "RobotModel":
        return self

    def holding(self, payload: Payload | None) -> "RobotModel":
        """Returns the same robot with another payload in its hand.

        The payload becomes the last link of the tree, and its spheres the last
        spheres; all other quantities change accordingly. Equal calls return the
        same object.

        Args:
            payload: The object that the robot carries; None if it carries no
                object.

        Raises:
            RemoSplatError: A link of the robot already has the payload's name,
                or the robot lacks the link that shall carry it.
        """
        empty = self if self._empty is None else self._empty
        return empty if payload is None else _holding(empty, payload)

    def _copied(self) -> "RobotModel":
        """Returns a copy without its cached properties."""
        copied = copy.copy(self)
        for name in vars(self):
            if isinstance(getattr(type(self), name, None), cached_property):
                delattr(copied, name)
        return copied

    def with_hand_width(self, width: float) -> "RobotModel":
        """Returns the same robot with its fingers at another width.

        Spheres and convex shapes of both fingers move by the same distance.
        Equal calls return the same object.

        Args:
            width: Opening of the hand, the sum of the fingers' positions [m].

        Raises:
            RemoSplatError: The robot has no hand, or its hand does not open
                that far.
        """
        if width == self.hand_width:
            return self
        return _opened(self.as_described, float(width)).holding(self.payload)

    @property
    def as_described(self) -> "RobotModel":
        """The robot with empty hand and the hand width of its description."""
        empty = self.holding(None)
        return empty if empty._described is None else empty._described

    @property
    def hand_width(self) -> float | None:
        """Opening of the hand in this model [m]; None without a hand."""
        fingers = self.fingers
        return float(self.tree.offset[fingers].sum()) if len(fingers) else None

    def _set_fingers(self, plant: MultibodyPlant):
        hand, fingers, limits = self.description.hand, [], []
        for joint in map(plant.GetJointByName, hand.joints if hand else ()):
            fingers.append(self.tree.index(joint.child_body().name()))
            lower, upper = (
                joint.position_lower_limits,
                joint.position_upper_limits,
            )
            limits.append([float(lower()[0]), float(upper()[0])])
        self.fingers = np.array(fingers, int)
        self._finger_limits = np.array(limits).reshape(-1, 2)

    def _with_hand_width(self, width: float) -> "RobotModel":
        hand = self.description.hand
        if hand is None:
            raise RemoSplatError("the robot has no hand whose width can be set")
        lower, upper = self._finger_limits[:, 0], self._finger_limits[:, 1]
        each = width / len(hand.joints)
        if not (lower - ROUNDING <= each).all() or (each > upper).any():
            least, most = lower.sum(), upper.sum()
            raise RemoSplatError(
                f"the hand opens from {least:g} to {most:g} m, not to {width:g}"
            )
        opened = self._copied()
        locked = self.description.locked | dict.fromkeys(hand.joints, each)
        opened.description = dc.replace(self.description, locked=locked)
        opened._described = self
        opened.tree = self.tree.with_offsets(self.fingers, each)
        opened.dynamics = dc.replace(self.dynamics, tree=opened.tree)
        return opened

    def _with_payload(self, payload: Payload) -> "RobotModel":
        held = self._copied()
        held.payload, held._empty = payload, self
        link = self.tree.index(payload.link)
        held.tree = self.tree.with_body(payload.name, link, payload.X_LO)
        held.dynamics = self.dynamics.holding(held.tree, payload)
        held._set_spheres(self.spheres.with_link(payload.name, payload.spheres))
        held._set_screws()
        return held

    def _set_spheres(self, spheres: SphereModel):
        self.spheres = spheres
        self._body_S = np.array([self.tree.index(x) for x in spheres.links])
        self._p_LS = np.ascontiguousarray(spheres.p_LS)
        self._radius = np.ascontiguousarray(spheres.radius)
        self._index = np.arange(len(spheres))
        floor = spheres.on_links(set(self.description.floor_links))
        self._ignore_below = np.where(floor, self._floor_height, -np.inf)

    @property
    def is_omnidirectional(self) -> bool:
        """Whether the robot has a base that can drive to the side."""
        return self.n_base == 3

    @property
    def assumed_actuators(self) -> list[Actuator]:
        """The assumed models of a real robot's axes, one for each command.

        They are the models in the description or, if not measured, cautious
        defaults.
        """
        return list(self.description.actuators) or default_actuators(
            self.n_base, self.n_u - self.n_base
        )

    def _check_allowed_collisions(self):
        links = self.tree.names[1:]
        for i, pair in enumerate(self.description.allowed_collisions):
            for name in pair:
                if name not in links:
                    raise FieldError(
                        self.description.source,
                        f"allowed_collisions[{i}]",
                        unknown_name("link", name, links),
                    )

    def _set_end_effectors(self, plant: MultibodyPlant):
        named = self.description.effector_frames
        self.effectors = tuple(named)
        bodies, X_LE = [], []
        for effector, name in named.items():
            source = self.description.source
            field = joined("end_effectors", effector)
            field = field if effector else "end_effector_frame"
            if not name:
                problem = (
                    "is missing; name a frame, or several under end_effectors"
                )
                raise FieldError(source, field, problem)
            frame = find_frame(plant, name, source, field)
            bodies.append(self.tree.index(frame.body().name()))
            X_LE.append(frame.GetFixedPoseInBodyFrame().GetAsMatrix4())
        self._body_E = np.array(bodies)
        self._X_LE = np.array(X_LE, order="C")

    def _set_screws(self):
        """Finds the screw of each command, and the bodies that it moves."""
        b = len(self.tree.names)
        joint_body = {
            int(position): body
            for body, position in enumerate(self.tree.position)
            if position >= 0
        }
        if self.description.base:
            self._body_B = self.tree.index(self.description.base.body)
            yaw_body = joint_body[2]
            bodies = [yaw_body] * self.n_base
        else:
            self._body_B = 0
            bodies = []
        bodies += [joint_body[i] for i in range(self._base_q, self.n_q)]
        self.screw_body = np.array(bodies)
        self.screw_turns = self.tree.kind[self.screw_body] == kin.REVOLUTE
        self.screw_turns[: max(self.n_base - 1, 0)] = False
        self._moves = np.zeros((b, self.n_u), bool)
        for body in range(1, b):
            chain = set(self.tree.chain(body))
            self._moves[body] = [s in chain for s in self.screw_body]

    @cached_property
    def hands(self) -> np.ndarray:
        """Mask of the spheres that each arm's last joint moves, (e, n), bool.

        The last joint of a single arm is the robot's last joint, with or
        without a hand.
        """
        last = self._last_bodies
        spheres = [self.tree.chain(body) for body in self._body_S]
        return np.array([[x in chain for chain in spheres] for x in last], bool)

    @property
    def _last_bodies(self) -> list[int]:
        """The bodies that the last joints of the arms move."""
        if len(self.effectors) == 1:
            return [int(self.screw_body[-1])]
        chains = map(self.tree.chain, self._body_E)
        moving = set(self.screw_body.tolist())
        return [[b for b in chain if b in moving][-1] for chain in chains]

    def effector_that_moves(self, body: int) -> int | None:
        """Returns the index of the end effector that moves with a body.

        Args:
            body: Index of a body of the robot's tree.

        Returns:
            The first end effector whose arm's last joint moves the body; None
            if none does.
        """
        chain = self.tree.chain(body)
        for effector, last in enumerate(self._last_bodies):
            if last in chain:
                return effector
        return None

    @property
    def leading_spheres(self) -> np.ndarray:
        """Mask of the spheres that any arm's last joint moves, (n,), bool."""
        return np.logical_or.reduce(self.hands)

    @cached_property
    def moved_by_arm(self) -> np.ndarray:
        """Mask of the spheres that any joint of an arm moves, (n,), bool."""
        moving = [
            any(self.tree.position[link] >= self._base_q for link in chain)
            for chain in map(self.tree.chain, range(len(self.tree.names)))
        ]
        return np.array(moving)[self._body_S]

    @cached_property
    def arm_turns(self) -> np.ndarray:
        """Mask of the arm's joints that are revolute, (n_arm,), bool."""
        kinds = dict(zip(self.tree.position, self.tree.kind, strict=True))
        arm = range(self._base_q, self.n_q)
        return np.array([kinds[i] == kin.REVOLUTE for i in arm], bool)

    @cached_property
    def home(self) -> np.ndarray:
        """The arm's home configuration, shape (n_arm,) [rad]."""
        return np.array(self.description.home, float)

    @property
    def q_home(self) -> np.ndarray:
        """The home configuration with the base at the origin, shape (n_q,)."""
        return np.concatenate([np.zeros(self._base_q), self.home])

    def rounded_into_limits(self, q: np.ndarray) -> np.ndarray:
        """Moves joints onto a limit that they exceed only by rounding errors.

        For example, files contain 3.1416 for a limit of pi. Larger excesses are
        not changed.

        Args:
            q: A configuration, shape (n_q,) [rad, m].

        Returns:
            The configuration, shape (n_q,).
        """
        inside = np.clip(q, self.position_lower, self.position_upper)
        return np.where(abs(inside - q) < ROUNDING, inside, q)

    @cached_property
    def most_beyond(self) -> np.ndarray:
        """Permitted excess of each joint at the start, (n_q,) [rad, m]."""
        turns = np.ones(self.n_q, bool)
        turns[self._base_q :] = self.arm_turns
        return np.where(turns, _MOST_TURNED_BEYOND, _MOST_SLID_BEYOND)

    def excess(self, q: np.ndarray) -> np.ndarray:
        """Computes the excess of each joint over its limits, (n_q,) [rad, m].

        Args:
            q: A configuration, shape (n_q,) [rad, m].
        """
        lower, upper = self.position_lower, self.position_upper
        return np.maximum(np.maximum(lower - q, q - upper), 0.0)

    def beyond_limits(self, q: np.ndarray) -> str:
        """Describes the joint farthest beyond its limits; "" if there is none.

        Args:
            q: A configuration, shape (n_q,) [rad, m].
        """
        excess, names = self.excess(q), self.joint_names
        if not excess.any():
            return ""
        i = int(excess.argmax())
        lower, upper = self.position_lower[i], self.position_upper[i]
        return (
            f"{names[i]} is beyond its limits: it is at {q[i]:g},"
            f" not between {lower:g} and {upper:g}"
        )

    def body_poses(self, q: np.ndarray) -> np.ndarray:
        """Computes the poses X_WL of all bodies of `tree`, shape (b, 4, 4)."""
        return kin.body_poses(self.tree.arrays, self._whole(q))[0]

    def _whole(self, q: np.ndarray) -> np.ndarray:
        """Copies a configuration and checks its shape; kernels do not."""
        q = np.array(q, float)
        if q.shape != (self.n_q,):
            problem = f"a configuration has shape ({self.n_q},), not {q.shape}"
            raise ValueError(problem)
        return q

    def end_effector_pose(self, q: np.ndarray, effector: int = 0) -> np.ndarray:
        """Computes the end-effector pose X_WE, shape (4, 4).

        Args:
            q: Configuration, shape (n_q,).
            effector: Index of the end effector.
        """
        return self.end_effector_poses(q)[effector]

    def end_effector_poses(self, q: np.ndarray) -> np.ndarray:
        """Computes the poses of all e end effectors, shape (e, 4, 4)."""
        X_WE, X_WL = np.empty_like(self._X_LE), self.body_poses(q)
        for i, body in enumerate(self._body_E):
            kin.compose(X_WL[body], self._X_LE[i], X_WE[i])
        return X_WE

    def spheres_at(self, q: np.ndarray) -> Spheres:
        """Places the robot's spheres in W at configuration q, shape (n_q,)."""
        X_WL = self.body_poses(q)
        p_WS, R_WL = kin.sphere_points(X_WL, self._body_S, self._p_LS)
        return self._all_placed(p_WS, R_WL)

    def state(self, q: np.ndarray) -> RobotState:
        """Computes all kinematic quantities at configuration q, (n_q,)."""
        return self.state_of(state_arrays(self.arrays, self._whole(q)))

    def state_of(self, arrays: StateArrays) -> RobotState:
        """Wraps kinematic quantities that a kernel has already computed.

        Args:
            arrays: The kinematic quantities of a configuration of this robot.
        """
        return RobotState(
            arrays,
            self._all_placed(arrays.p_WS, arrays.R_WL),
            self.arrays,
        )

    def velocity_map(self, q: np.ndarray) -> np.ndarray:
        """Computes N(q) with q_dot = N(q) u, shape (n_q, n_u).

        A differential base cannot slip sideways: this is its nonholonomic
        constraint.
        """
        N = np.zeros((self.n_q, self.n_u))
        arm = np.arange(self.n_q - self._base_q)
        N[self._base_q + arm, self.n_base + arm] = 1.0
        if self.n_base:
            c, s = np.cos(q[2]), np.sin(q[2])
            slides = np.array([[c, -s], [s, c]])
            N[:2, : self.n_base - 1] = slides[:, : self.n_base - 1]
            N[2, self.n_base - 1] = 1.0
        return N

    def sphere_tube(self, tube: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Bounds deviations of spheres from predicted paths, shape (n,) [m].

        Args:
            tube: Errors of positions divided by speeds, shape (n_u,) [s].
            speed: Greatest speeds, shape (n_u,) [m/s, rad/s].
        """
        return self.jacobian_bound @ (tube * speed)

    def advance(self, q: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
        """Integrates the configuration while u is held for dt [s], exactly."""
        return kin.advance(q.astype(float), u, self.n_base, dt)

    def advance_for(
        self, q: np.ndarray, u: np.ndarray, times: np.ndarray
    ) -> np.ndarray:
        """Integrates the configuration while u is held, for several durations.

        Args:
            q: Configuration to start from, shape (n_q,).
            u: Command that is held, shape (n_u,).
            times: Durations, each from the start, shape (k,) [s].

        Returns:
            The configuration after each duration, shape (k, n_q).
        """
        return kin.advance_for(q.astype(float), u, self.n_base, times)

    def place_spheres(
        self, states: np.ndarray, state: np.ndarray, sphere: np.ndarray
    ) -> Spheres:
        """Places chosen spheres, each at one of several configurations.

        Args:
            states: Configurations, shape (k, n_q).
            state: Row of `states` for each wanted sphere, shape (m,);
                consecutive equal rows are computed once.
            sphere: Index of each wanted sphere, shape (m,).
        """
        p_WS, R_WL = kin.sphere_points_at(
            self.tree.arrays,
            states,
            state,
            self._body_S[sphere],
            self._p_LS[sphere],
        )
        return self.placed(sphere, p_WS, R_WL)

    def spheres_of_all(self, states: np.ndarray) -> Spheres:
        """Places all n spheres at each of several configurations.

        Args:
            states: Configurations, shape (k, n_q).

        Returns:
            k n spheres, beginning with those of the first configuration.
        """
        k, n = len(states), len(self.spheres)
        return self.place_spheres(
            states, np.repeat(np.arange(k), n), np.tile(np.arange(n), k)
        )

    def placed(
        self, sphere: np.ndarray, p_WS: np.ndarray, R_WL: np.ndarray
    ) -> Spheres:
        """Makes `Spheres` from computed positions of some spheres.

        Args:
            sphere: Indices of the spheres, shape (m,).
            p_WS: Centres of the spheres in W, shape (m, 3) [m].
            R_WL: Orientations of the spheres' links, shape (m, 3, 3).
        """
        return Spheres(
            p_WS,
            R_WL,
            self._radius[sphere],
            self._ignore_below[sphere],
            sphere,
        )

    def _all_placed(self, p_WS: np.ndarray, R_WL: np.ndarray) -> Spheres:
        return Spheres(
            p_WS, R_WL, self._radius, self._ignore_below, self._index
        )

    @cached_property
    def arrays(self) -> Packed[RobotArrays]:
        """The robot packed for kernels."""
        values = RobotArrays(
            self.tree.arrays.values,
            self._body_S,
            self._p_LS,
            self._radius,
            self.hessian_bound,
            self._ignore_below,
            self._index,
            self.jacobian_bound,
            self.hands,
            self._body_E,
            self._X_LE,
            self._body_B,
            self.n_base,
            self.tree.axis_F[self.screw_body],
            self.screw_body,
            self.screw_turns,
            self._moves,
            self.velocity_limit,
            self.acceleration_limit,
            self.position_lower,
            self.position_upper,
        )
        return Packed(values)

    @cached_property
    def chains(self) -> tuple[SerialChain, ...]:
        """The serial chain of joints that move each end effector."""
        return tuple(
            SerialChain.make(self.tree, body, X_LE)
            for body, X_LE in zip(self._body_E, self._X_LE, strict=True)
        )

    @cached_property
    def chain_arrays(self) -> tuple[Packed[SerialChain], ...]:
        """The chains, packed for kernels."""
        return tuple(map(Packed, self.chains))

    @cached_property
    def joint_reach(self) -> np.ndarray:
        """Largest absolute position of each joint, shape (n_q,) [m, rad].

        Joints may start beyond their limits by `most_beyond`, which is
        included.
        """
        reach = np.maximum(-self.position_lower, self.position_upper)
        return reach + self.most_beyond

    @cached_property
    def jacobian_bound(self) -> np.ndarray:
        """Bounds on |dp_WS/du_j| over all configurations, shape (n, n_u).

        They bound the spheres' Jacobians [m/rad or 1].
        """
        return jacobian_bound(
            self.tree,
            self.joint_reach,
            (self.screw_body, self.screw_turns),
            self._body_S,
            self._p_LS,
        )

    @cached_property
    def hessian_bound(self) -> np.ndarray:
        """Bounds on |d2p_WS / dq_j dq_k|, shape (n, n_u, n_u).

        While u is held, no sphere's velocity changes by more than
        |u|' hessian_bound |u| [m/s^2].
        """
        moves = self._moves[self._body_S]
        return hessian_bound(self.jacobian_bound, self.screw_turns, moves)

    @cached_property
    def sphere_tree(self) -> Packed[SphereTree]:
        """The tree of balls around the robot's spheres."""
        screws = self.screw_body, self.screw_turns

        def bend(body: np.ndarray, p_LS: np.ndarray) -> np.ndarray:
            reach, turns = self.joint_reach, self.screw_turns
            bound = jacobian_bound(self.tree, reach, screws, body, p_LS)
            return hessian_bound(bound, turns, self._moves[body])

        ignore_below = self._ignore_below
        return Packed(
            SphereTree.make(self.spheres, self._body_S, ignore_below, bend)
        )


@lru_cache(maxsize=16)
def _holding(robot: RobotModel, payload: Payload) -> RobotModel:
    return robot._with_payload(payload)


@lru_cache(maxsize=64)
def _opened(robot: RobotModel, width: float) -> RobotModel:
    return robot._with_hand_width(width)


@reads_file
def load_robot(
    name: str | Path,
    spheres: str = "covering",
    floor_height: float = -np.inf,
) -> RobotModel:
    """Loads a robot by the name of a folder in models/ or by its YAML file.

    Args:
        name: A name such as `frankie`, or the path of a robot description.
        spheres: Name of one of the description's sphere sets.
        floor_height: Spheres of the robot's floor links ignore scene points
            below this height [m]; -inf for no height.

    Raises:
        RemoSplatError: The robot or sphere set does not exist, or does not fit
            its model.

    Example:
        >>> import remosplat_drake as rs
        >>> robot = rs.load_robot("frankie")
        >>> robot.n_q, robot.n_u
        (10, 9)
    """
    description = load_robot_description(name)
    covering = load_sphere_model(description.spheres_path(spheres))
    return RobotModel(description, covering, floor_height)
