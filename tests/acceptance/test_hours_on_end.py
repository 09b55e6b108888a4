"""Hours on end: twenty minutes of them, on the wire and by the clock."""

import subprocess
from collections.abc import Callable

import pytest
from patience import PATIENCE
from robot_process import Client, robot_process
from runs import PATIENT, command_line

from apps.studies.hours import drive_for
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.hardware_processes import free_url

STOPPED_BY_USER = "the arm's mode is user_stopped"


@pytest.mark.slow
def test_nothing_grows_and_no_stop_ends_the_run(wire):
    """It is stopped every three minutes, and by nothing else."""
    run = drive_for(20.0, 3.0, is_busy=True)
    assert run.stops == (STOPPED_BY_USER,) * run.caused
    assert run.caused == 6
    assert run.growth < 5.0, run
    (first, _), (last, _) = run.periods_first, run.periods_last
    assert last == pytest.approx(first, rel=0.05)
    assert run.exit_code == 130


@pytest.mark.slow
def test_a_headless_run_waits_for_its_operator_after_a_stop(wire, tmp_path):
    url = free_url()
    line = command_line(
        *("run", "TableReach", "--hardware", "--without-doctor"),
        *("--headless", "--lcm-url", url, "--output", tmp_path),
        *("--scenario-text", PATIENT),
    )
    with robot_process(url, "TableReach"):
        client, operator = Client(url), Consent(url, again=True)
        client.wait_for_robot()

        def asks_until(done: Callable[[], bool]) -> None:
            def asked() -> bool:
                operator.give()
                return done()

            client.wait_for(asked)

        with subprocess.Popen(line, stderr=subprocess.PIPE, text=True) as run:
            asks_until(
                lambda: max(map(abs, client.latest.joint_velocity)) > 0.05
            )
            client.inject("user-stop")
            client.wait_for(lambda: client.latest.robot_mode == 5)
            assert run.poll() is None
            client.inject("recover")
            asks_until(lambda: run.poll() is not None)
            _, said = run.communicate(timeout=PATIENCE)
    assert run.returncode == 0, said
    assert "user_stopped" in said and "reached" in said, said
