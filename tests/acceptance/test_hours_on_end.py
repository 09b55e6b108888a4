"""Hours on end: twenty minutes by `make test-all`, else a minute."""

from collections.abc import Callable

import pytest
from effort import effort
from patience import PATIENCE
from pydrake.lcm import DrakeLcm
from robot_process import Client, robot_process, running
from runs import PATIENT

from apps.studies.hours import drive_for
from remosplat_drake.acceptance.consent import Consent
from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.hardware.client.operator import Operator

STOPPED_BY_USER = "the arm's mode is user_stopped"


MINUTES, STOP_EVERY = effort((1.0, 0.3), (20.0, 3.0))
"""How long the robot is driven, and time between two stops [min]."""


@pytest.mark.slow
@pytest.mark.timeout(60.0 * MINUTES + 2 * PATIENCE)
def test_nothing_grows_and_no_stop_ends_the_run(wire):
    """It is stopped now and then, and by nothing else."""
    run = drive_for(MINUTES, STOP_EVERY, is_busy=True)
    assert run.stops == (STOPPED_BY_USER,) * run.caused
    assert run.caused == effort(3, 6)
    assert run.targets >= 3 * MINUTES
    (first, _), (last, _) = run.periods_first, run.periods_last
    assert last == pytest.approx(first, rel=0.05)
    assert run.exit_code == 130
    if MINUTES > 10.0:
        # A first minute fills caches.
        assert run.growth < 5.0, run


@pytest.mark.slow
def test_a_headless_run_waits_for_its_operator_after_a_stop(wire, tmp_path):
    url = free_url()
    line = [
        *("run", "TableReach", "--hardware", "--without-doctor"),
        *("--headless", "--lcm-url", url, "--output", str(tmp_path)),
        *("--scenario-text", PATIENT),
    ]
    with robot_process(url, "TableReach"):
        client, operator = Client(url), Consent(url, again=True)
        watch = Operator(DrakeLcm(url))
        client.wait_for_robot()

        def asks_until(done: Callable[[], bool]) -> None:
            def asked() -> bool:
                operator.give()
                return done()

            client.wait_for(asked)

        with running(*line) as run:
            asks_until(
                lambda: max(map(abs, client.latest.joint_velocity)) > 0.05
            )
            client.inject("user-stop")
            # A stop that is shorter than a control period may be overlooked.
            client.wait_for(
                lambda: any(
                    STOPPED_BY_USER in lease.reason for lease in watch.leases()
                )
            )
            assert run.poll() is None
            client.inject("recover")
            asks_until(lambda: run.poll() is not None)
            summary, said = run.communicate(timeout=PATIENCE)
    assert run.returncode == 0, said
    assert "user_stopped" in said, said
    assert "reached" in summary, summary
