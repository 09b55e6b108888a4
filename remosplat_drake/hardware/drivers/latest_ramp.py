"""`LatestRamp`: stores the latest braking ramp that a driver has received."""

from contextlib import suppress

from remosplat_drake.hardware.wire.packets import BrokenMessage
from remosplat_drake.hardware.wire.ramp import Ramp, decode_ramp


class LatestRamp:
    """Stores the latest ramp, and finds the ramp of a command by its stamp."""

    def __init__(self):
        """Starts without a ramp."""
        self._ramp: Ramp | None = None

    def receive(self, data: bytes) -> None:
        """Stores an encoded ramp; a malformed ramp is ignored."""
        with suppress(BrokenMessage):
            self._ramp = decode_ramp(data)

    def of(self, utime: int) -> Ramp | None:
        """Returns the ramp of a command; None if there is none.

        Args:
            utime: The command's stamp [us].
        """
        ramp = self._ramp
        return ramp if ramp is not None and ramp.utime == utime else None
