"""Gates: checks that a run must pass, or a person accept, before motion.

Other functions check a run's map and settings, and return a `Gate` for each
fault. `open_gates` then permits the run or refuses it. The consequence of each
gate is a refusal, a warning or none, and may differ between simulation and a
real robot. A refusal ends the run before it begins, unless a person has
accepted the gate by its name; a warning is printed.
"""

import dataclasses as dc
from collections.abc import Collection, Mapping, Sequence

from remosplat_drake.base.errors import RemoSplatError, unknown_name

CAPTURE_WARNINGS = "capture-warnings"
EMPTY_MAP = "empty-map"
IGNORED_SPLATS = "ignored-splats"
MAP_ERROR = "map-error"
NO_WAY_OUT = "no-way-out"
START_BEYOND_LIMITS = "start-beyond-limits"
START_TOO_NEAR = "start-too-near"
TARGET_OUT_OF_REACH = "target-out-of-reach"
UNKNOWN_MAP_ERROR = "unknown-map-error"
UNKNOWN_SEEN_SPACE = "unknown-seen-space"
UNSEEN_SPACE = "unseen-space"

GATES = {
    CAPTURE_WARNINGS: "the capture that the map was made of is doubtful",
    EMPTY_MAP: "the map has no data where the robot starts or moves",
    IGNORED_SPLATS: "most splats within reach are too faint or cropped away",
    MAP_ERROR: "a stopping distance is too small for the map's error",
    NO_WAY_OUT: "no motion out of the start configuration is found",
    START_BEYOND_LIMITS: "a joint starts beyond its limits",
    START_TOO_NEAR: "the robot starts too near to itself or to the scene",
    TARGET_OUT_OF_REACH: "the arm is too short for a target",
    UNKNOWN_MAP_ERROR: "the accuracy of the map has not been measured",
    UNKNOWN_SEEN_SPACE: "the space that the map's cameras saw is not known",
    UNSEEN_SPACE: "the robot may go where no camera has looked",
}
"""Names of all gates (checks before motion), each with the fault that it
reports."""

SILENCE, WARNING, REFUSAL = "silence", "warning", "refusal"
"""Possible consequences of a gate."""


@dc.dataclass(frozen=True)
class Gate:
    """Something that is wrong with a run before it begins.

    Attributes:
        name: Name of the gate, a key of `GATES`.
        problem: What is wrong and, if there is one, a remedy.
        in_simulation: Consequence of the gate in simulation: `SILENCE`,
            `WARNING` or `REFUSAL`.
        on_hardware: Consequence of the gate on a real robot, with the same
            values.
    """

    name: str
    problem: str
    in_simulation: str = WARNING
    on_hardware: str = REFUSAL

    def __str__(self) -> str:
        return f"{self.name}: {self.problem}"

    def leads_to(self, hardware: bool) -> str:
        """Returns the gate's consequence, in simulation or on a real robot."""
        return self.on_hardware if hardware else self.in_simulation


@dc.dataclass(frozen=True)
class Passage:
    """The gates that are shut although the run may begin.

    Attributes:
        warnings: Gates that only lead to a warning in this run.
        accepted: Gates that a person has accepted by their names.
    """

    warnings: tuple[Gate, ...] = ()
    accepted: tuple[Gate, ...] = ()


def check_names(
    names: Collection[str], valid: Mapping[str, str] = GATES
) -> None:
    """Checks the names of gates that a person accepts.

    Args:
        names: The accepted names.
        valid: All existing names, and their meanings.

    Raises:
        RemoSplatError: A name is unknown; the text lists the valid ones.
    """
    for name in names:
        if name not in valid:
            raise RemoSplatError(
                f"--accept: {unknown_name('gate', name, valid)}"
            )


def open_gates(
    gates: Sequence[Gate],
    accepted: Collection[str],
    *,
    hardware: bool,
    where: str,
    otherwise: str = "to run anyway",
) -> Passage:
    """Permits a run, or refuses it.

    Args:
        gates: The gates that are shut: the faults that were found.
        accepted: Names of the gates that a person accepts. Names of gates that
            are not shut have no effect.
        hardware: Whether a real robot moves.
        where: The scenario that the error names.
        otherwise: Purpose of the flags `--accept` that the error lists.

    Returns:
        The warnings, and the gates that were accepted.

    Raises:
        RemoSplatError: A gate leads to a refusal and is not accepted; one
            line names all of them.
    """
    rest = [gate for gate in gates if gate.name not in accepted]
    refusals = [g for g in rest if g.leads_to(hardware) == REFUSAL]
    if refusals:
        problems = "; ".join(gate.problem for gate in refusals)
        names = dict.fromkeys(gate.name for gate in refusals)
        flags = " ".join(f"--accept {name}" for name in names)
        raise RemoSplatError(f"{where}: {problems} ({otherwise}: {flags})")
    taken = tuple(gate for gate in gates if gate.name in accepted)
    warnings = tuple(g for g in rest if g.leads_to(hardware) == WARNING)
    return Passage(warnings, taken)
