"""RTDE's packets, and the controller's loop with ur_rtde's program."""

import numpy as np
import pytest

from remosplat_drake.hardware.stand_in.rtde_packets import (
    NOT_FOUND,
    Kind,
    Recipe,
    packet,
    split,
    type_of,
)
from remosplat_drake.hardware.stand_in.ur_rules import (
    DONE,
    READY,
    Command,
    SafetyMode,
    UrRules,
)

CYCLE = 0.002
FAST = [0.2, 0.0, 0.0, 0.0, 0.0, -0.1, 4.0, 0.0]


def test_packets_are_split_where_they_end():
    first, second = packet(Kind.START), packet(Kind.TEXT, b"hello")
    assert first == b"\x00\x03S"
    buffer = bytearray(first + second[:-1])
    assert split(buffer) == [(Kind.START, b"")]
    buffer += second[-1:]
    assert split(buffer) == [(Kind.TEXT, b"hello")]
    with pytest.raises(ValueError, match="2 bytes"):
        split(bytearray(b"\x00\x02S"))


def test_a_recipe_reads_what_it_writes():
    recipe = Recipe(["timestamp", "actual_q", "output_int_register_7"])
    assert recipe.types == ["DOUBLE", "VECTOR6D", "INT32"]
    data = recipe.pack({"timestamp": 1.5, "actual_q": [1, 2, 3, 4, 5, 6]})
    assert len(data) == 8 + 48 + 4
    assert recipe.unpack(data) == {
        "timestamp": [1.5],
        "actual_q": [1, 2, 3, 4, 5, 6],
        "output_int_register_7": [0],
    }
    with pytest.raises(ValueError, match="requires"):
        recipe.unpack(data[:-1])
    assert type_of("output_int_register_x") == NOT_FOUND


def run(rules: UrRules, command: int, values=FAST, cycles=1, fresh=True):
    for _ in range(cycles):
        rules.step(CYCLE, command, values, fresh)


def test_speeds_are_followed_in_a_straight_line():
    rules = UrRules()
    run(rules, Command.SPEED_J)
    assert not rules.velocity.any(), "no program was uploaded"
    rules.start_script()
    run(rules, Command.SPEED_J)
    np.testing.assert_allclose(rules.velocity[[0, 5]], [0.008, -0.004])
    assert rules.state == READY
    run(rules, Command.SPEED_J, cycles=30)
    np.testing.assert_allclose(rules.velocity, FAST[:6])


def test_other_commands_are_answered_until_they_are_withdrawn():
    rules = UrRules()
    rules.start_script()
    run(rules, Command.SPEED_J, cycles=30)
    run(rules, Command.SPEED_STOP, [4.0] * 8)
    assert rules.state == DONE
    run(rules, Command.SPEED_J)
    assert rules.state == DONE, "the one before was not withdrawn"
    run(rules, Command.NONE, cycles=30)
    assert rules.state == READY
    assert not rules.velocity.any()


def test_the_watchdog_ends_the_program_of_who_falls_silent():
    rules = UrRules()
    rules.start_script()
    run(rules, Command.SET_WATCHDOG, [10.0] * 8)
    run(rules, Command.NONE)
    run(rules, Command.SPEED_J, cycles=30)
    run(rules, Command.SPEED_J, cycles=45, fresh=False)
    assert rules.is_running
    run(rules, Command.SPEED_J, cycles=20, fresh=False)
    assert not rules.is_running
    assert not rules.velocity.any()


def test_a_protective_stop_brakes_and_wants_to_be_unlocked():
    rules = UrRules()
    rules.start_script()
    run(rules, Command.SPEED_J, cycles=30)
    rules.stop(SafetyMode.PROTECTIVE_STOP)
    run(rules, Command.SPEED_J, cycles=10)
    assert not rules.velocity.any()
    rules.start_script()
    assert not rules.is_running
    rules.recover()
    rules.start_script()
    assert rules.is_running
