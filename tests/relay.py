"""A relay process: a network between two wires, with delay and loss.

    python tests/relay.py URL_A URL_B --delay 0.05 --loss 0.2 --seed 1

Commands go from A to B, statuses from B to A. What is lost is drawn from the
seed, message by message; the order of messages is kept.
"""

import argparse
import contextlib
import heapq
import subprocess
import sys
import time
from collections.abc import Iterator

import numpy as np
from pydrake.lcm import DrakeLcm

from remosplat_drake.drivers.inbox import Inbox
from remosplat_drake.messages import channels

COMMANDS = [
    channels.PANDA_COMMAND,
    channels.BASE_COMMAND,
    channels.PANDA_HAND_COMMAND,
]
STATUSES = [
    channels.PANDA_STATUS,
    channels.BASE_STATUS,
    channels.PANDA_HAND_STATUS,
    channels.WRIST_CAMERA,
]


class Relay:
    """Forwards commands one way and statuses the other."""

    def __init__(self, a: DrakeLcm, b: DrakeLcm, delay: float, loss: float):
        self._ways = [(Inbox(a, COMMANDS), b), (Inbox(b, STATUSES), a)]
        self._delay, self._loss = delay, loss
        self._under_way: list[tuple[float, int, DrakeLcm, str, bytes]] = []
        self._count = 0

    def step(self, now: float, rng: np.random.Generator) -> None:
        """Takes what has come, sends what is due at time `now` [s]."""
        for inbox, to in self._ways:
            for channel, data in inbox.fetch():
                self._count += 1
                if rng.random() >= self._loss:
                    due = now + self._delay
                    heapq.heappush(
                        self._under_way, (due, self._count, to, channel, data)
                    )
        while self._under_way and self._under_way[0][0] <= now:
            _, _, to, channel, data = heapq.heappop(self._under_way)
            to.Publish(channel, data)


@contextlib.contextmanager
def relay_process(
    a: str, b: str, delay: float = 0.05, loss: float = 0.2, seed: int = 0
) -> Iterator[subprocess.Popen[str]]:
    """The relay between two wires, ready; commands go from a to b."""
    with subprocess.Popen(
        [
            *(sys.executable, __file__, a, b),
            *("--delay", str(delay), "--loss", str(loss), "--seed", str(seed)),
        ],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout
            assert process.stdout.readline() == "ready\n"
            yield process
        finally:
            process.terminate()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("a")
    parser.add_argument("b")
    parser.add_argument("--delay", type=float, default=0.0)
    parser.add_argument("--loss", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    rng = np.random.default_rng(arguments.seed)
    relay = Relay(
        DrakeLcm(arguments.a),
        DrakeLcm(arguments.b),
        arguments.delay,
        arguments.loss,
    )
    print("ready", flush=True)
    while True:
        relay.step(time.monotonic(), rng)
        time.sleep(2e-4)


if __name__ == "__main__":
    main()
