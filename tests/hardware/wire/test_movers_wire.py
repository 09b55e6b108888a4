"""Movers survive the wire, or are refused with the name of what is wrong."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from remosplat_drake.hardware.wire.messages.mover_list import (
    mover_list as Message,
)
from remosplat_drake.hardware.wire.movers import (
    LONGEST_NAME,
    decode_movers,
    encode_movers,
)
from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.scene.mover import MOST, Mover, Movers
from remosplat_drake.scene.mover_camera import MoverCamera

DOOR = Mover(
    "door",
    RigidTransform(RollPitchYaw(0.1, -0.2, 0.3), [1, 2, 3]),
    np.array([0.4, 0.02, 1.0]),
    0.01,
    np.array([0.1, 0.2, 0.3]),
    np.array([-0.1, 0.0, 0.5]),
    1.5,
    4.0,
    0.05,
    0.02,
)
BALL = Mover.sphere("ball", [0, 0, 1], 0.1)
CAMERA = MoverCamera(
    "room",
    RigidTransform(RollPitchYaw(1, 2, 3), [4, 5, 6]),
    np.array([-0.6, -0.5]),
    np.array([0.7, 0.4]),
    0.3,
    5.0,
    1_700_000_000.125,
    "it is dark",
)
MOVERS = Movers(1_700_000_000.25, [DOOR, BALL], [CAMERA])


def test_they_survive_the_wire():
    got = decode_movers(encode_movers(MOVERS))
    assert got.stamp == pytest.approx(MOVERS.stamp, abs=1e-6)
    for name, value in MOVERS.at(MOVERS.stamp)._asdict().items():
        np.testing.assert_allclose(
            getattr(got.at(got.stamp), name), value, atol=1e-15
        )
    assert [mover.name for mover in got] == ["door", "ball"]
    (camera,) = got.cameras
    assert (camera.name, camera.problem) == ("room", "it is dark")
    assert (camera.near, camera.far) == (0.3, 5.0)
    assert camera.seen == pytest.approx(CAMERA.seen, abs=1e-6)
    assert camera.X_WC.IsNearlyEqualTo(CAMERA.X_WC, 1e-12)
    np.testing.assert_array_equal(camera.least_tangent, CAMERA.least_tangent)
    np.testing.assert_array_equal(
        camera.greatest_tangent, CAMERA.greatest_tangent
    )


def test_nothing_that_moves_is_news_too():
    got = decode_movers(encode_movers(Movers(1.5)))
    assert (got.stamp, len(got), got.cameras) == (1.5, 0, ())


def test_names_are_cut():
    movers = Movers(1.0, [Mover.sphere("x" * 5000, [0, 0, 0], 0.1)])
    (got,) = decode_movers(encode_movers(movers))
    assert got.name == "x" * LONGEST_NAME


def broken(change) -> bytes:
    message = Message.decode(encode_movers(MOVERS))
    change(message)
    return message.encode()


def put(field: str, value, i: int = 1):
    def change(message: Message):
        values = list(getattr(message, field))
        values[i] = value
        setattr(message, field, values)

    return change


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda m: setattr(m, "utime", 0), "has no stamp"),
        (lambda m: setattr(m, "utime", -5), "has no stamp"),
        (lambda m: setattr(m, "version", 2), "has version 2; valid: 1"),
        (put("radius", np.nan), r"movers\[1\]\.radius is nan"),
        (put("radius", -0.1), "mover 'ball'.*radius.*at least 0"),
        (put("position", [0, np.inf, 0]), r"movers\[1\]\.position\[1\] is inf"),
        (put("velocity", [np.nan] * 3), r"movers\[1\]\.velocity\[0\] is nan"),
        (put("half_extents", [0, 0, -1.0]), "mover 'ball'.*half_extents"),
        (put("max_speed", np.inf), r"movers\[1\]\.max_speed is inf"),
        (put("velocity_error", -1.0), "mover 'ball'.*velocity_error"),
        (
            put("quaternion", [0.0] * 4),
            r"movers\[1\]\.quaternion has the norm 0",
        ),
        (put("near", np.nan, 0), "camera 'room'.*near"),
        (put("camera_quaternion", [np.nan] * 4, 0), r"cameras\[0\]\.quatern"),
        (put("least_tangent", [2.0, 2.0], 0), "camera 'room'.*least_tangent"),
    ],
)
def test_what_cannot_be_used_is_named(change, problem):
    with pytest.raises(BrokenMessage, match=problem):
        decode_movers(broken(change))


def test_a_thousand_are_too_many():
    message = Message.decode(encode_movers(MOVERS))
    message.num_movers = 1000
    for field, kind in zip(
        message.__slots__, message.__dimensions__, strict=True
    ):
        if kind and kind[0] == "num_movers":
            setattr(message, field, [getattr(message, field)[0]] * 1000)
    with pytest.raises(BrokenMessage, match=f"1000 movers; at most {MOST}"):
        decode_movers(message.encode())


@pytest.mark.parametrize("share", [0.0, 0.02, 0.1, 0.4, 0.7, 0.99])
def test_a_packet_that_is_cut_short_is_refused(share):
    data = encode_movers(MOVERS)
    with pytest.raises(BrokenMessage, match="not a whole mover_list"):
        decode_movers(data[: int(share * len(data))])


@pytest.mark.parametrize("number", [-1, 2**31 - 1])
def test_a_number_that_lies_is_refused(number):
    data = bytearray(encode_movers(Movers(1.0)))
    data[20:24] = number.to_bytes(4, "big", signed=True)
    with pytest.raises(BrokenMessage):
        decode_movers(bytes(data))
