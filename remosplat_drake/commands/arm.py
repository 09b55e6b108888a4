"""`remosplat arm`: arms a real robot that waits for an operator."""

import argparse

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands.tables import open_console
from remosplat_drake.commands.wire import add_wire_argument, open_wire
from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.hardware.hardware_config import REHEARSAL_URL
from remosplat_drake.hardware.wire.lease import LEASE_EXPIRY, Lease
from remosplat_drake.signals.supervisor_state import STOPPED

_STAYS = 1
_PATIENCE = 1.0
"""`arm` waits at most this long for the answers of controllers [s]."""

EXAMPLES = """
remosplat arm
remosplat arm --rehearsal
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    add_wire_argument(parser)
    parser.add_argument(
        "--rehearsal",
        action="store_true",
        help=(
            "arm the simulated robot of `remosplat hardware-sim` at "
            f"{REHEARSAL_URL}"
        ),
    )
    parser.add_argument(
        "--session",
        type=int,
        metavar="N",
        help="number of the controller's session to arm; needed if several "
        "controllers wait",
    )


def run(arguments: argparse.Namespace) -> int:
    """Arms the robot of one controller; returns 1 if it remains stopped."""
    console = open_console(highlight=False)
    url = REHEARSAL_URL if arguments.rehearsal else arguments.lcm_url
    operator = Operator(open_wire(url))
    lease = _chosen(operator.listen_for(LEASE_EXPIRY), arguments.session, url)
    console.print(f"{lease.identity}: {lease.mode}: {lease.reason}")
    operator.arm(lease.identity.session)
    answers = {a.identity: a for a in operator.listen_for(_PATIENCE)}
    answer = answers.get(lease.identity, lease)
    console.print(": ".join(filter(None, (answer.mode, answer.reason))))
    return _STAYS if answer.mode == STOPPED else 0


def _chosen(leases: list[Lease], session: int | None, url: str) -> Lease:
    """Returns the controller's session to arm.

    Raises:
        RemoSplatError: No controller waits, or several controllers wait.
    """
    if session is not None:
        leases = [
            lease for lease in leases if lease.identity.session == session
        ]
    if not leases:
        raise RemoSplatError(f"no controller at {url} waits for an operator")
    if len(leases) > 1:
        names = "; ".join(f"{a.identity.session}: {a.identity}" for a in leases)
        raise RemoSplatError(
            f"several controllers at {url} wait for an operator; choose one"
            f" with --session: {names}"
        )
    return leases[0]
