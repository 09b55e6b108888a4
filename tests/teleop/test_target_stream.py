"""Poses from another program: on time, late, broken and missing."""

import numpy as np
import pytest

from remosplat_drake.hardware.wire.messages.pose_target import pose_target
from remosplat_drake.hardware.wire.messages.velocity_target import (
    velocity_target,
)
from remosplat_drake.hardware.wire.packets import to_utime
from remosplat_drake.teleop.target_stream import (
    POSES,
    VELOCITIES,
    StreamState,
    advance_stream,
    merged_command,
)

EXPIRY = 0.3
NOW = 1_700_000_000.0


def packet(sent: float, position=(1.0, 2.0, 3.0), quaternion=(2, 0, 0, 0)):
    message = pose_target()
    message.utime = to_utime(NOW + sent)
    message.position = list(position)
    message.quaternion = list(quaternion)
    return message.encode()


def look(state: StreamState, time: float, data: bytes | None) -> StreamState:
    return advance_stream(POSES, state, data, NOW + time, EXPIRY)


def flowing(until: float = 0.5) -> StreamState:
    state = StreamState()
    for time in np.arange(0.0, until, 0.1):
        state = look(state, time, packet(time))
    return state


def test_before_the_first_pose_nothing_is_wished():
    state = look(StreamState(), 9.0, None)
    assert (state.command.moves, state.command.trouble) == (0, "")
    assert state.command.X_WT is None


def test_a_stream_takes_hold_once():
    state = flowing()
    assert (state.command.moves, state.command.trouble) == (1, "")
    assert state.command.source == "pose stream"
    assert state.command.X_WT is not None
    np.testing.assert_allclose(state.command.X_WT[:3, 3], [1, 2, 3])
    np.testing.assert_allclose(state.command.X_WT[:3, :3], np.eye(3))


def test_silence_ends_it():
    state = flowing()
    assert look(state, 0.69, None).flows
    state = look(state, 0.71, None)
    assert state.command.trouble == "the pose stream has been silent for 0.3 s"
    # It goes on: a new stream, which takes hold again.
    state = look(state, 2.0, packet(2.0))
    assert (state.command.moves, state.command.trouble) == (2, "")


def test_a_clock_set_back_ends_it():
    assert not look(flowing(), -5.0, None).flows


def test_a_packet_sent_twice_does_not_keep_it_alive():
    state = flowing()
    same = packet(0.4)
    assert look(state, 0.5, same).flows
    assert not look(state, 0.7001, same).flows


@pytest.mark.parametrize("sent", [0.1, 0.9])
def test_a_pose_too_old_or_from_the_future_ends_it(sent):
    state = look(flowing(), 0.5, packet(sent))
    assert not state.flows
    assert "old on arrival" in state.command.trouble
    assert state.command.moves == 1


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "not a whole pose_target"),
        (packet(0.5)[:-3], "not a whole pose_target"),
        (packet(0.5, position=(np.nan, 0, 0)), "position[0] is nan"),
        (packet(0.5, quaternion=(0, 0, np.inf, 0)), "quaternion[2] is inf"),
        (
            packet(0.5, quaternion=(0, 0, 0, 0)),
            "quaternion has the norm 0, not 1",
        ),
    ],
    ids=["empty", "short", "position", "quaternion", "zero"],
)
def test_broken_packets(data, problem):
    state = look(flowing(), 0.5, data)
    assert not state.flows
    assert state.command.trouble.startswith("the pose stream is broken: ")
    assert problem in state.command.trouble


def test_a_quaternion_of_any_length_will_do():
    state = look(flowing(), 0.5, packet(0.5, quaternion=(0, 0, 0, 1e200)))
    assert state.command.X_WT is not None
    R = state.command.X_WT[:3, :3]
    np.testing.assert_allclose(R, np.diag([-1, -1, 1]), atol=1e-15)


def twist(sent: float, angular=(0.0, 0.0, 0.1)) -> bytes:
    message = velocity_target()
    message.utime = to_utime(NOW + sent)
    message.angular, message.linear = list(angular), [0.2, 0.0, 0.0]
    return message.encode()


def test_velocities_lead_while_they_flow():
    def look_at(state: StreamState, time: float, data: bytes | None):
        return advance_stream(VELOCITIES, state, data, NOW + time, EXPIRY)

    poses = flowing()
    state = look_at(StreamState(), 0.5, twist(0.5))
    command = merged_command((poses, state))
    assert (command.source, command.trouble) == ("velocity stream", "")
    np.testing.assert_array_equal(command.V_W, [0, 0, 0.1, 0.2, 0, 0])
    assert command.moves == 1
    ended = look_at(state, 0.81, None)
    command = merged_command((poses, ended))
    assert command.V_W is None
    text = "the velocity stream has been silent for 0.3 s"
    assert command.trouble == text
    # A stream of poses that begins later leads again.
    again = look(look(poses, 0.9, None), 0.95, packet(0.95))
    command = merged_command((again, ended))
    assert (command.moves, command.trouble) == (2, "")
    broken = look_at(state, 0.6, twist(0.6, (np.nan, 0, 0)))
    assert broken.command.V_W is None
    assert "angular[0] is nan" in broken.command.trouble
    assert "old on arrival" in look_at(state, 1.0, twist(0.6)).command.trouble


def test_a_state_is_not_copied():
    state = StreamState()
    assert state.__deepcopy__({}) is state
