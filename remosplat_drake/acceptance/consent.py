"""`Consent`: a simulated operator of acceptance tests that releases robots."""

import math
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.signals.supervisor_state import STOPPED, UNARMED

_AGAIN = 0.2
"""Time after which the operator repeats a request [s]."""


class Consent:
    """Arms, over the network, the controllers that wait for a release."""

    def __init__(self, url: str, *, again: bool = False):
        """Joins the LCM network of the controllers.

        Args:
            url: Its LCM URL.
            again: Whether to release robots that have been stopped, too.
        """
        self._operator, self._again = Operator(DrakeLcm(url)), again
        self._asked = -math.inf

    def give(self) -> None:
        """Arms the controllers that wait now; call it periodically."""
        leases = self._operator.leases()
        if time.monotonic() - self._asked < _AGAIN:
            return
        for lease in leases:
            stands = self._again and lease.mode == STOPPED
            if stands or lease.reason.startswith(UNARMED):
                self._operator.arm(lease.identity.session)
                self._asked = time.monotonic()
