"""`Consent`: the operator of acceptance tests, who lets every robot go."""

import math
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.signals.supervisor_state import UNARMED

_AGAIN = 0.2
"""Time after which an operator asks once more [s]."""


class Consent:
    """Arms, over the wire, the controllers that wait for it; once each."""

    def __init__(self, url: str):
        """Joins the controllers' wire at an LCM URL."""
        self._operator = Operator(DrakeLcm(url))
        self._asked = -math.inf

    def give(self) -> None:
        """Arms whoever waits now; it is to be called again and again."""
        leases = self._operator.leases()
        if time.monotonic() - self._asked < _AGAIN:
            return
        for lease in leases:
            if lease.reason.startswith(UNARMED):
                self._operator.arm(lease.who.session)
                self._asked = time.monotonic()
