"""`StopRequest`: Ctrl-C and SIGTERM, asked for between two steps."""

import signal


class StopRequest:
    """Whether somebody has asked the process to end.

    An exception out of a signal could strike in the middle of a message, or
    of the ramp at the end. So a first signal is noted only; a second one
    interrupts, in case the first was never looked at.
    """

    _SIGNALS = (signal.SIGINT, signal.SIGTERM)

    def __init__(self):
        """Takes over both signals."""
        self.received = False
        for number in self._SIGNALS:
            signal.signal(number, self._note)

    def _note(self, *_) -> None:
        self.received = True
        for number in self._SIGNALS:
            signal.signal(number, signal.default_int_handler)
