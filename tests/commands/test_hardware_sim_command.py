"""`remosplat hardware-sim`: a real process, heard and driven over the wire."""

import math
from functools import partial

import numpy as np
import pytest
from patience import PATIENCE
from robot_process import Client, robot_process

from remosplat_drake.acceptance.hardware_processes import free_url

pytestmark = pytest.mark.usefixtures("lone_robot")

MOVE, REFLEX = 2, 4
STILL = 1e-3  # [rad/s]

SLOWLY = np.array([0.1, 0, 0, 0, 0, 0, -0.2])


def moves_slowly(client: Client) -> bool:
    return np.allclose(client.latest.joint_velocity, SLOWLY, atol=2e-3)


def stands(client: Client) -> bool:
    return np.abs(client.latest.joint_velocity).max() < STILL


def is_younger(client: Client, time: float) -> bool:
    return bool(client.arm) and client.time < time


def test_a_robot_is_driven_broken_and_recovered_over_the_wire():
    url = free_url()
    with robot_process(url) as process:
        client = Client(url)
        client.wait_for_robot()
        first = client.arm[0]
        client.drive(lambda: moves_slowly(client), SLOWLY)
        client.send_hand(0.06, 10.0)
        client.wait_for(
            lambda: abs(client.hand[-1].actual_position_mm - 60) < 1
        )
        # No controller commands any more: it stops by itself, where it is then.
        client.wait_for(lambda: stands(client))
        moved = np.subtract(client.latest.joint_position, first.joint_position)
        assert moved[0] > 0
        assert moved[6] == pytest.approx(-2 * moved[0], rel=0.1)
        np.testing.assert_allclose(moved[1:6], 0, atol=1e-3)
        client.inject("reflex")
        client.wait_for(lambda: client.latest.robot_mode == REFLEX)
        client.inject("recover")
        client.drive(
            lambda: client.latest.robot_mode == MOVE and moves_slowly(client),
            SLOWLY,
        )
        process.terminate()
        assert process.wait(PATIENCE) == 0
    utime = [(status.utime, status.robot_utime) for status in client.arm]
    assert (np.diff(utime, axis=0) > 0).all()


@pytest.mark.slow
def test_faults_on_a_schedule_and_a_record_of_the_motion(tmp_path):
    url, record = free_url(), tmp_path / "motion.npz"

    def gap() -> float:
        utime = [status.robot_utime for status in client.arm]
        return np.diff(utime).max(initial=0) / 1e6

    with robot_process(
        url, "--fault", "status-stops@0.3+0.2", "--record", str(record)
    ) as process:
        client = Client(url)
        client.wait_for_robot()
        client.drive(lambda: gap() > 0.19 and moves_slowly(client), SLOWLY)
        process.terminate()
        assert process.wait(PATIENCE) == 0
    motion = np.load(record)
    assert motion["q"].shape[1] == 10
    assert motion["u"].shape == (len(motion["q"]), 9)
    assert motion["u"][:, 2].max() == pytest.approx(0.1, abs=0.01)


@pytest.mark.slow
def test_a_message_that_is_no_command_ends_the_process():
    url = free_url()
    with robot_process(url) as process:
        client = Client(url)
        client.wait_for_robot()
        client.send_arm(np.zeros(6))
        assert process.wait(PATIENCE) == 2
        assert process.stderr
        lines = process.stderr.read().splitlines()
    assert lines[-1] == (
        "remosplat: PANDA_COMMAND: num_joint_velocity: must be 7, got 6"
    )


@pytest.mark.slow
def test_a_killed_robot_comes_back_on_the_same_wire():
    url = free_url()
    client, before = Client(url), math.inf
    for _ in range(2):
        with robot_process(url) as process:
            # Its own clock begins anew.
            client.wait_for(partial(is_younger, client, before))
            client.drive(lambda: moves_slowly(client), SLOWLY)
            before = client.time
            process.kill()
            process.wait(PATIENCE)
