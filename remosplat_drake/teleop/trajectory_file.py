"""Reads an operator's script: timed requests, in a YAML file.

steps:
- {time: 1, translation: [1.1, 0, 0.7], rpy_deg: [180, 0, 0]}
- {time: 4, press: frame}
- {time: 5, pick: shelf}
- {time: 9, press: home}
- {time: 12, effector: right, translation: [0.6, -0.3, 0.9]}
- {time: 20, take: can}
- {time: 45, put_on: tray}
"""

import dataclasses as dc
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Interval

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.base.ranges import Config, Position, RollPitchYawDeg
from remosplat_drake.base.reading import reads_file
from remosplat_drake.base.strict_yaml import load_strict
from remosplat_drake.robot.robot_description import unknown_effector
from remosplat_drake.scene.objects.scene_object import new_name
from remosplat_drake.scene.primitive_scene import PrimitiveScene
from remosplat_drake.signals.map_requests import MapRequests, scene_in_turn
from remosplat_drake.signals.operator_command import OperatorCommand
from remosplat_drake.teleop.teleop_config import SavedPose

SOURCE = "trajectory"
"""Name of this source of commands, for messages to the operator."""

_TARGET_BUTTONS = {
    "hold": "holds",
    "home": "homes",
    "scan": "scans",
    "open": "opens",
    "close": "closes",
}
_MAP_BUTTONS = {
    "frame": "frames",
    "refine": "refines",
    "undo": "undos",
    "save": "saves",
}

SCENE = "scene"
"""Button that switches a simulated camera to its next true scene."""

BUTTONS = (*_TARGET_BUTTONS, *_MAP_BUTTONS, SCENE)
"""Names of the buttons that a step of a script can press."""


NO_OBJECTS = (
    "needs a simulation of a scenario that has `objects` and the setting"
    " `mapping: {enabled: false}`"
)
"""Error text for a step that finds, takes or places an object in a run that
does not permit this."""


@dc.dataclass
class OperatorStep(Config):
    """A step of a script: a requested pose, a press of a button, or both."""

    # Time of the step, since the start of the run [s].
    time: Annotated[float, Interval(ge=0, le=1e6)] = 0.0
    # Position in the world frame W to which the target shall move [m]; absent:
    # the step requests no pose.
    translation: Position | None = None
    # Roll, pitch and yaw that the target shall have in W [deg]; absent: the
    # angles of the previous step.
    rpy_deg: RollPitchYawDeg | None = None
    # Name of a button to press; empty: press no button.
    press: str = ""
    # Name of a saved pose to pick; empty: pick no pose.
    pick: str = ""
    # Name of the end effector that moves from this step on, if there are
    # several. If it is empty, the end effector does not change. A script begins
    # with the first end effector.
    effector: str = ""
    # Point x, y, z in W on an object of the map that becomes an object of the
    # run [m]; absent: find no object. The first one is called "object 1".
    find: Position | None = None
    # Name of an object to take; empty: take no object.
    take: str = ""
    # Name of an object on which to place the carried object; empty: do not
    # place it.
    put_on: str = ""
    # Point x, y, z in W near which to place the carried object [m]; absent:
    # below the hand.
    near: Position | None = None

    def check(self) -> Iterator[tuple[str, str]]:
        """Yields errors: an unknown button; a rotation without a position."""
        if self.rpy_deg is not None and self.translation is None:
            yield "rpy_deg", "needs a translation"
        if self.near is not None and not self.put_on:
            yield "near", "needs the field put_on"
        if self.press and self.press not in BUTTONS:
            yield "press", unknown_name("button", self.press, BUTTONS)


@dc.dataclass
class TrajectoryFile(Config):
    """Content of an operator's script."""

    # The steps of the script, in the order of time.
    steps: list[OperatorStep] = dc.field(default_factory=list)


@dc.dataclass(frozen=True, eq=False)
class AccumulatedRequests:
    """All requests of a script until a time.

    Attributes:
        time: Time of the latest request [s].
        command: All requests to the target by then.
        map_requests: All requests to the live map by then.
    """

    time: float
    command: OperatorCommand
    map_requests: MapRequests


@reads_file
def load_operator_steps(
    path: Path,
    poses: Collection[str],
    scenes: Sequence[PrimitiveScene] = (),
    effectors: Collection[str] = ("",),
    objects: Collection[str] = (),
) -> list[OperatorStep]:
    """Reads and checks an operator's script.

    Args:
        path: The YAML file.
        poses: Names of the saved poses that steps may pick.
        scenes: The scenes of a simulated camera, between which a step may
            switch.
        effectors: Names of the robot's end effectors.
        objects: Names of the objects that steps may take or put down.

    Raises:
        FileError: The file is missing or not YAML.
        FieldError: A step is unusable; the text names it.
    """
    steps = load_strict(TrajectoryFile, path).steps
    if not steps:
        raise FieldError(str(path), "steps", "there are none")
    before, known = 0.0, list(objects)
    for i, step in enumerate(steps):
        if step.find is not None and objects:
            known.append(new_name(known))
        _check_step(step, before, poses, str(path), f"steps[{i}]")
        if step.effector and step.effector not in effectors:
            raise FieldError(
                str(path),
                f"steps[{i}].effector",
                unknown_effector(step.effector, effectors),
            )
        for name in ("take", "put_on"):
            thing = getattr(step, name)
            if thing and thing not in known:
                problem = unknown_name("object", thing, known)
                if not objects:
                    problem = NO_OBJECTS
                raise FieldError(str(path), f"steps[{i}].{name}", problem)
        if step.press == SCENE and len(scenes) < 2:
            raise FieldError(
                str(path),
                f"steps[{i}].press",
                f"{SCENE!r} needs a simulation, and a scenario whose"
                " scene.truth_later names the file of the other scene",
            )
        if step.find is not None and not objects:
            raise FieldError(str(path), f"steps[{i}].find", NO_OBJECTS)
        before = step.time
    return steps


def _check_step(
    step: OperatorStep,
    before: float,
    poses: Collection[str],
    where: str,
    field: str,
) -> None:
    if not step.time >= before:
        raise FieldError(
            where,
            f"{field}.time",
            f"must not be before {before:g}, got {step.time:g}",
        )
    if step.pick and step.pick not in poses:
        problem = unknown_name("saved pose", step.pick, poses)
        raise FieldError(where, f"{field}.pick", problem)
    asks = (
        step.translation,
        step.press,
        step.pick,
        step.effector,
        step.find,
        step.take,
        step.put_on,
    )
    if not any(asks):
        raise FieldError(
            where,
            field,
            "requests nothing; give translation, press, pick, effector, find, "
            "take or put_on",
        )


def accumulate_requests(
    steps: Sequence[OperatorStep], scenes: Sequence[PrimitiveScene] = ()
) -> list[AccumulatedRequests]:
    """Accumulates the requests of a script over time.

    Args:
        steps: The steps, in the order of time.
        scenes: The scenes of a simulated camera, which shows the first scene at
            the start.

    Returns:
        The requests up to each time: first an empty entry at -inf, then one
        entry for each step.
    """
    command, requests = OperatorCommand(source=SOURCE), MapRequests()
    asked = [AccumulatedRequests(-np.inf, command, requests)]
    pose = SavedPose()
    changes = 0
    for step in steps:
        if step.effector:
            command = dc.replace(
                command, effector=step.effector, choices=command.choices + 1
            )
        if step.translation is not None:
            rpy_deg = step.rpy_deg or pose.rpy_deg
            pose = SavedPose(step.translation, rpy_deg)
            command = dc.replace(
                command, X_WT=pose.matrix(), moves=command.moves + 1
            )
        if step.pick:
            command = dc.replace(
                command, pose=step.pick, poses=command.poses + 1
            )
        if step.find is not None:
            command = dc.replace(
                command, p_WFind=np.array(step.find), finds=command.finds + 1
            )
        if step.take:
            command = dc.replace(
                command, thing=step.take, takes=command.takes + 1
            )
        if step.put_on:
            command = dc.replace(
                command,
                support=step.put_on,
                p_WNear=None if step.near is None else np.array(step.near),
                places=command.places + 1,
            )
        if step.press in _TARGET_BUTTONS:
            command = _more(command, _TARGET_BUTTONS[step.press])
        if step.press in _MAP_BUTTONS:
            requests = _more(requests, _MAP_BUTTONS[step.press])
        if step.press == SCENE:
            changes += 1
            scene = scene_in_turn(scenes, changes)
            requests = dc.replace(requests, scene=scene)
        asked.append(AccumulatedRequests(step.time, command, requests))
    return asked


def _more(counts, field: str):
    return dc.replace(counts, **{field: getattr(counts, field) + 1})
