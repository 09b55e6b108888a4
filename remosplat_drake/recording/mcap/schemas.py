"""JSON schemas of the messages in an MCAP file.

Schemas whose names begin with `foxglove.` are subsets of Foxglove's own
schemas. So Foxglove's panels show these messages without a plugin.
"""

NUMBER = {"type": "number"}
TEXT = {"type": "string"}
COUNT = {"type": "integer", "minimum": 0}
NUMBERS = {"type": "array", "items": NUMBER}


def _record(title: str, optional: tuple[str, ...] = (), **properties) -> dict:
    """Returns the schema of an object with required and optional properties."""
    return {
        "title": title,
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
    }


def _several(items: dict) -> dict:
    return {"type": "array", "items": items}


TIME = _record("time", sec=COUNT, nsec={**COUNT, "maximum": 999_999_999})

_TRANSFORM = _record(
    "foxglove.FrameTransform",
    timestamp=TIME,
    parent_frame_id=TEXT,
    child_frame_id=TEXT,
    translation=_record("foxglove.Vector3", x=NUMBER, y=NUMBER, z=NUMBER),
    rotation=_record(
        "foxglove.Quaternion", x=NUMBER, y=NUMBER, z=NUMBER, w=NUMBER
    ),
)

_ALL = (
    _record("foxglove.FrameTransforms", transforms=_several(_TRANSFORM)),
    _record(
        "foxglove.JointStates",
        timestamp=TIME,
        joints=_several(
            _record(
                "foxglove.JointState",
                optional=("position", "velocity"),
                name=TEXT,
                position=NUMBER,
                velocity=NUMBER,
            )
        ),
    ),
    _record(
        "foxglove.Log",
        timestamp=TIME,
        level={"type": "integer", "enum": [0, 1, 2, 3, 4, 5]},
        message=TEXT,
        name=TEXT,
        file=TEXT,
        line=COUNT,
    ),
    _record(
        "foxglove.CompressedImage",
        timestamp=TIME,
        frame_id=TEXT,
        data={**TEXT, "contentEncoding": "base64"},
        format={"type": "string", "enum": ["jpeg", "png"]},
    ),
    _record(
        "remosplat.Command",
        timestamp=TIME,
        commanded=NUMBERS,
        executed=NUMBERS,
        status=TEXT,
        reason=TEXT,
        scale=NUMBER,
        duration=NUMBER,
    ),
    _record("remosplat.Supervision", timestamp=TIME, mode=TEXT, reason=TEXT),
    _record(
        "remosplat.StationStatus",
        timestamp=TIME,
        optional=("age",),
        age=NUMBER,
        mode=TEXT,
        stop_reason=TEXT,
        robot_mode=TEXT,
        success_rate=NUMBER,
        protective_stop={"type": "boolean"},
    ),
    _record(
        "remosplat.Clearances",
        timestamp=TIME,
        optional=("minimum", "link"),
        minimum=NUMBER,
        link=TEXT,
        links={"type": "object", "additionalProperties": NUMBER},
    ),
    _record("remosplat.Recorder", timestamp=TIME, left_out=COUNT),
)

SCHEMAS = {schema["title"]: schema for schema in _ALL}
"""All schemas, keyed by name."""
