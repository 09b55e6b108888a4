"""A process that simulates a faulty network: it delays and loses messages.

    python -m remosplat_drake.acceptance.network_relay URL_A URL_B --delay 0.05

It forwards commands from LCM URL A to B, and statuses from B to A. Each message
is lost at random, determined by a seed. The order of messages does not change.
Messages are delayed and lost only between a first and a second SIGUSR1.
"""

import argparse
import heapq
import signal
import time

import numpy as np
from pydrake.lcm import DrakeLcm

from remosplat_drake.hardware.wire import channels
from remosplat_drake.hardware.wire.inbox import Inbox
from remosplat_drake.hardware.wire.lease import DRIVER_REPORT, SESSION_LEASE

COMMANDS = [
    channels.COMMAND_RAMP,
    channels.PANDA_COMMAND,
    channels.BASE_COMMAND,
    channels.PANDA_HAND_COMMAND,
    SESSION_LEASE,
]
STATUSES = [
    channels.PANDA_STATUS,
    channels.BASE_STATUS,
    channels.PANDA_HAND_STATUS,
    DRIVER_REPORT,
]

READY = "ready"
"""Line that the relay prints when it has joined both networks."""

_PERIOD = 2e-4
"""Both networks are polled once in this time [s]."""


class Relay:
    """Forwards commands from LCM URL a to b, and statuses from b to a.

    Attributes:
        delay: Delay of every message from now on [s].
        loss: Fraction of messages that are lost from now on, in [0, 1].
    """

    def __init__(self, a: DrakeLcm, b: DrakeLcm):
        """Joins the networks a (controller) and b (robot), without faults."""
        self._ways = [(Inbox(a, COMMANDS), b), (Inbox(b, STATUSES), a)]
        self._under_way: list[tuple[float, int, DrakeLcm, str, bytes]] = []
        self._count = 0
        self.delay = self.loss = 0.0

    def step(self, now: float, rng: np.random.Generator) -> None:
        """Receives messages, and sends those that are due at time `now` [s]."""
        for inbox, to in self._ways:
            for channel, data in inbox.fetch():
                self._count += 1
                if rng.random() >= self.loss:
                    due = now + self.delay
                    heapq.heappush(
                        self._under_way, (due, self._count, to, channel, data)
                    )
        while self._under_way and self._under_way[0][0] <= now:
            _, _, to, channel, data = heapq.heappop(self._under_way)
            to.Publish(channel, data)


def main() -> None:
    """Runs the relay until a signal ends the process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("a")
    parser.add_argument("b")
    parser.add_argument("--delay", type=float, default=0.0, help="[s]")
    parser.add_argument("--loss", type=float, default=0.0, help="a share")
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    relay = Relay(DrakeLcm(arguments.a), DrakeLcm(arguments.b))

    bad, good = (arguments.delay, arguments.loss), (0.0, 0.0)

    def switch(*_) -> None:
        is_good = (relay.delay, relay.loss) == good
        relay.delay, relay.loss = bad if is_good else good

    signal.signal(signal.SIGUSR1, switch)
    print(READY, flush=True)
    while True:
        relay.step(time.monotonic(), rng)
        time.sleep(_PERIOD)


if __name__ == "__main__":
    main()
