"""Gates: faults that prevent a run, unless a person accepts them by name.

Other modules check a run's map and settings, and make a `Gate` for each fault.
`open_gates` then permits or refuses the run. The consequence of a gate is a
refusal, a warning or none, and may differ between simulation and a real robot.
A refusal ends the run before it begins, unless a person has accepted the gate
by its name. A warning is printed.
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
    CAPTURE_WARNINGS: "checks have found faults in the capture of the map",
    EMPTY_MAP: "the map has no data where the robot starts or moves",
    IGNORED_SPLATS: "most splats within reach are too faint or cropped away",
    MAP_ERROR: "a stopping distance is too small for the map's error",
    NO_WAY_OUT: "no motion away from the start configuration was found",
    START_BEYOND_LIMITS: "a joint starts beyond its limits",
    START_TOO_NEAR: "the robot starts too near to itself or to the scene",
    TARGET_OUT_OF_REACH: "the arm is too short for a target",
    UNKNOWN_MAP_ERROR: "the accuracy of the map has not been measured",
    UNKNOWN_SEEN_SPACE: "the space that the map's cameras saw is not known",
    UNSEEN_SPACE: "the robot may go where no camera has looked",
}
"""Names of all gates (checks before motion), and the fault that each
reports."""

SILENCE, WARNING, REFUSAL = "silence", "warning", "refusal"
"""Possible consequences of a gate."""


@dc.dataclass(frozen=True)
class Gate:
    """A fault of a run's map or settings, found before the run begins.

    Attributes:
        name: Name of the gate, a key of `GATES`.
        problem: Description of the fault and, if possible, of a remedy.
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
    """The gates that a permitted run has: warnings and accepted gates.

    Attributes:
        warnings: Gates whose consequence in this run is only a warning.
        accepted: Gates that a person has accepted by their names.
    """

    warnings: tuple[Gate, ...] = ()
    accepted: tuple[Gate, ...] = ()


def check_names(
    names: Collection[str], valid: Mapping[str, str] = GATES
) -> None:
    """Checks that the names of accepted gates exist.

    Args:
        names: The accepted names.
        valid: All existing names of gates, and their meanings.

    Raises:
        RemoSplatError: A name is unknown. The error lists the valid names.
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
    """Permits or refuses a run.

    Args:
        gates: The faults that were found before the run.
        accepted: Names of the gates that a person accepts. Names of gates that
            are not in `gates` have no effect.
        hardware: Whether a real robot moves.
        where: The scenario; the error names it.
        otherwise: Text of the error, before the flags `--accept`, that states
            their purpose.

    Returns:
        The warnings, and the gates that were accepted.

    Raises:
        RemoSplatError: The consequence of a gate is a refusal, and the gate is
            not accepted. The error names all such gates in one line.
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
