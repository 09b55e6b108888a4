"""Converts a tick to messages of the schemas in `schemas`."""

import base64
import dataclasses as dc
import io
import math
from collections.abc import Iterator

import numpy as np
from pydrake.math import RotationMatrix

from remosplat_drake.base.system_libraries import import_optional
from remosplat_drake.hardware.wire.images import CameraImages
from remosplat_drake.recording.events import SUPERVISOR, TROUBLE, Event
from remosplat_drake.recording.mcap.tick_record import TickRecord
from remosplat_drake.robot.robot_model import RobotModel

WORLD, TARGET, CAMERA = "world", "target", "wrist_camera"
"""Names of frames: the world W, the target T and the camera C. If there are
several end effectors, their names are appended to the names of the targets."""

_INFO, _WARNING = 2, 3
_LEVELS = {TROUBLE: _WARNING, SUPERVISOR: _WARNING}
"""Levels of foxglove.Log, keyed by the kind of event. All other kinds have the
level info."""

_QUALITY = 80
"""Quality of JPEG images, 1 to 100."""

_FARTHEST = 65.0
"""Largest depth that the file can contain [m]. Larger depths do not fit in 16
bits, and are stored as unknown."""


@dc.dataclass(frozen=True)
class Message:
    """A message of an MCAP file.

    Attributes:
        topic: Name of the channel.
        schema: Name of the schema.
        content: The fields, as JSON types.
    """

    topic: str
    schema: str
    content: dict

    @property
    def nanoseconds(self) -> int:
        """Time of the message since the Unix epoch [ns]."""
        content = self.content
        at = content.get("timestamp") or content["transforms"][0]["timestamp"]
        return at["sec"] * 10**9 + at["nsec"]


def stamp(time: float) -> dict:
    """Returns a time [s] as seconds and nanoseconds."""
    nanoseconds = max(0, round(1e9 * time))
    return dict(zip(("sec", "nsec"), divmod(nanoseconds, 10**9), strict=True))


def tick_messages(record: TickRecord, robot: RobotModel) -> Iterator[Message]:
    """Yields the messages of a tick, except the transforms.

    Args:
        record: The tick.
        robot: The robot.
    """
    at = {"timestamp": stamp(record.time)}
    yield Message(
        "/command",
        "remosplat.Command",
        at
        | {
            "commanded": record.commanded.tolist(),
            "executed": record.executed.tolist(),
            "status": record.status,
            "reason": record.reason,
            "scale": record.scale,
            "duration": record.duration,
        },
    )
    yield Message(
        "/joint_states",
        "foxglove.JointStates",
        at | {"joints": _joints(record, robot)},
    )
    yield Message(
        "/clearances",
        "remosplat.Clearances",
        at | _clearances(record, robot),
    )
    if record.mode:
        content = at | {"mode": record.mode, "reason": record.stop_reason}
        yield Message("/supervision", "remosplat.Supervision", content)
    if record.station is not None:
        station = dc.asdict(record.station)
        if not math.isfinite(station["age"]):
            del station["age"]
        content = at | {
            name: station[name] for name in station if name in _STATION
        }
        yield Message("/station_status", "remosplat.StationStatus", content)
    yield from map(log, record.events)


_STATION = (
    "age",
    "mode",
    "stop_reason",
    "robot_mode",
    "success_rate",
    "protective_stop",
)


def _joints(record: TickRecord, robot: RobotModel) -> list[dict]:
    """Returns the arm's joint positions; the transforms contain the base's."""
    names = robot.description.arm.joints
    q = record.q[-len(names) :].tolist()
    return [
        {"name": name, "position": position}
        for name, position in zip(names, q, strict=True)
        if math.isfinite(position)
    ]


def _clearances(record: TickRecord, robot: RobotModel) -> dict:
    """Returns each link's smallest clearance within the oracle's range."""
    links: dict[str, float] = {}
    robot = robot.holding(record.payload)
    for sphere, distance in zip(
        record.sphere.tolist(), record.distance.tolist(), strict=True
    ):
        link = robot.spheres.links[sphere]
        links[link] = min(distance, links.get(link, math.inf))
    if not links:
        return {"links": {}}
    nearest = min(links, key=links.__getitem__)
    return {"minimum": links[nearest], "link": nearest, "links": links}


def log(event: Event) -> Message:
    """Converts an event to a foxglove.Log message.

    Args:
        event: The event.
    """
    content = {
        "timestamp": stamp(event.time),
        "level": _LEVELS.get(event.kind, _INFO),
        "message": event.text,
        "name": event.kind,
        "file": "",
        "line": 0,
    }
    return Message("/events", "foxglove.Log", content)


def transforms(record: TickRecord, robot: RobotModel) -> Message | None:
    """Returns the poses of all links and targets in the world.

    Args:
        record: The tick.
        robot: The robot.

    Returns:
        The message; None if the robot has not been measured yet.
    """
    if not np.isfinite(record.q).all():
        return None
    X_W = dict(zip(robot.tree.names, robot.body_poses(record.q), strict=True))
    X_W.pop(WORLD, None)
    for effector, target in record.aim.items:
        if target.is_known:
            name = f"{TARGET}_{robot.effectors[effector]}".rstrip("_")
            X_W[name] = target.X_WT
    at = stamp(record.time)
    content = {"transforms": [_transform(at, *item) for item in X_W.items()]}
    return Message("/tf", "foxglove.FrameTransforms", content)


def _transform(at: dict, name: str, X_WF: np.ndarray) -> dict:
    R_WF = RotationMatrix.ProjectToRotationMatrix(X_WF[:3, :3])
    quaternion = R_WF.ToQuaternion()
    return {
        "timestamp": at,
        "parent_frame_id": WORLD,
        "child_frame_id": name,
        "translation": dict(zip("xyz", X_WF[:3, 3].tolist(), strict=True)),
        "rotation": {axis: getattr(quaternion, axis)() for axis in "xyzw"},
    }


def image_messages(images: CameraImages) -> Iterator[Message]:
    """Yields the camera's colours as JPEG and its depths as PNG.

    Args:
        images: Images of the camera. Depths are stored as whole millimetres in
            16 bits; 0 means unknown.
    """
    known = np.isfinite(images.depth) & (images.depth < _FARTHEST)
    steps = np.where(known, np.rint(1e3 * images.depth), 0).astype(np.uint16)
    for topic, pixels, name in (
        ("/wrist_camera/color", images.rgb, "jpeg"),
        ("/wrist_camera/depth", steps, "png"),
    ):
        content = {
            "timestamp": stamp(images.stamp),
            "frame_id": CAMERA,
            "data": _compressed(pixels, name),
            "format": name,
        }
        yield Message(topic, "foxglove.CompressedImage", content)


def _compressed(pixels: np.ndarray, name: str) -> str:
    pictures = import_optional("PIL.Image", "images in a recording", "record")
    file = io.BytesIO()
    picture = pictures.fromarray(np.ascontiguousarray(pixels))
    if name == "jpeg":
        picture.save(file, name, quality=_QUALITY)
    else:
        picture.save(file, name, compress_level=1)
    return base64.b64encode(file.getvalue()).decode()
