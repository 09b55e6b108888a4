"""Gates, without any robot: what passes, what is told, what is refused."""

import pytest

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.safety.gates import (
    EMPTY_MAP,
    GATES,
    IGNORED_SPLATS,
    MAP_ERROR,
    REFUSAL,
    Gate,
    Passage,
    check_names,
    open_gates,
)

EMPTY = Gate(EMPTY_MAP, "nothing is there")
FAINT = Gate(IGNORED_SPLATS, "nearly all is faint")
WRONG = Gate(MAP_ERROR, "0.021 is too small", in_simulation=REFUSAL)


def passage(*gates: Gate, accept=(), hardware: bool = False) -> Passage:
    return open_gates(gates, accept, hardware=hardware, where="a.yaml:A")


def refusal(*gates: Gate, accept=(), hardware: bool = False) -> str:
    with pytest.raises(RemoSplatError) as caught:
        passage(*gates, accept=accept, hardware=hardware)
    message = str(caught.value)
    assert message.startswith("a.yaml:A: ") and "\n" not in message
    return message


def test_nothing_wrong_lets_everybody_pass():
    assert passage() == passage(hardware=True) == Passage()


def test_a_simulation_is_warned():
    assert passage(EMPTY, FAINT) == Passage(warnings=(EMPTY, FAINT))


def test_a_real_robot_is_refused_what_a_simulation_is_warned_of():
    message = refusal(EMPTY, hardware=True)
    assert "nothing is there" in message
    assert "--accept empty-map" in message


def test_some_things_are_refused_in_simulation_too():
    message = refusal(EMPTY, WRONG)
    assert "0.021 is too small" in message
    assert "--accept map-error" in message
    # Of what leads to a warning only nothing has to be accepted.
    assert "empty-map" not in message


def test_one_line_names_all_that_is_refused():
    message = refusal(EMPTY, WRONG, FAINT, hardware=True)
    for gate in (EMPTY, WRONG, FAINT):
        assert gate.problem in message
        assert f"--accept {gate.name}" in message


@pytest.mark.parametrize("hardware", [False, True])
def test_what_is_accepted_is_passed_and_remembered(hardware):
    accept = [MAP_ERROR, EMPTY_MAP]
    assert passage(WRONG, EMPTY, accept=accept, hardware=hardware) == Passage(
        accepted=(WRONG, EMPTY)
    )


def test_accepting_one_thing_accepts_nothing_else():
    message = refusal(EMPTY, WRONG, accept=[EMPTY_MAP], hardware=True)
    assert "--accept map-error" in message
    assert "empty-map" not in message


def test_what_was_not_needed_does_not_count():
    done = passage(FAINT, accept=[MAP_ERROR, EMPTY_MAP])
    assert done == Passage(warnings=(FAINT,))


def test_an_unknown_name_is_told_the_valid_ones():
    check_names(GATES)
    with pytest.raises(RemoSplatError, match="did you mean 'empty-map'") as e:
        check_names([MAP_ERROR, "emty-map"])
    assert all(name in str(e.value) for name in GATES)
