"""`Consent`: a simulated operator that permits robots to move."""

import math
import time

from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.client.operator import Operator
from remosplat_drake.signals.supervisor_state import STOPPED, UNARMED

_AGAIN = 0.2
"""A request without an answer is repeated after this time [s]."""


class Consent:
    """Arms those controllers on a network that wait for a release."""

    def __init__(self, url: str, *, again: bool = False):
        """Joins the LCM network of the controllers.

        Args:
            url: LCM URL of the network.
            again: Whether robots that have been stopped are also released.
        """
        self._operator, self._again = Operator(DrakeLcm(url)), again
        self._asked = -math.inf

    def give(self) -> None:
        """Arms the controllers that wait now; must be called periodically."""
        leases = self._operator.leases()
        if time.monotonic() - self._asked < _AGAIN:
            return
        for lease in leases:
            stands = self._again and lease.mode == STOPPED
            if stands or lease.reason.startswith(UNARMED):
                self._operator.arm(lease.identity.session)
                self._asked = time.monotonic()
