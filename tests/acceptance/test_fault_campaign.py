"""The fault campaign: robot and controller as processes, a wire apart."""

import dataclasses as dc

import pytest
from runs import PATIENT

from remosplat_drake.acceptance.fault_campaign import run_case
from remosplat_drake.acceptance.fault_cases import CASES
from remosplat_drake.acceptance.fault_run import FaultRun

REPRESENTATIVE = {"status stops", "controller killed"}
"""One stop by the supervisor and one by the drivers, in every suite."""


def marked(case):
    marks = () if case.name in REPRESENTATIVE else (pytest.mark.slow,)
    return pytest.param(case, id=case.name, marks=marks)


@pytest.mark.parametrize("case", [marked(case) for case in CASES])
def test_the_robot_stays_safe(case, wire, table):
    if case.ros2:
        pytest.importorskip("cyclonedds", reason="needs the extra ros2")
    if case.name in REPRESENTATIVE:
        # Beside other tests, a late tick would stop it once more.
        case = dc.replace(case, text=PATIENT)
    result = run_case(case, table)
    assert result.problem == "", result


def test_a_robot_that_does_not_start_is_named(wire, tmp_path):
    (case,) = (case for case in CASES if case.name == "status stops")
    problem = FaultRun(case, tmp_path, ["false"]).carry_out()
    assert problem == (
        "the robot never moved: the simulated robot has ended with exit code 1"
    )


def test_every_case_has_a_name_of_its_own():
    names = [case.name for case in CASES]
    assert len(set(names)) == len(names)
    assert set(names) >= REPRESENTATIVE
