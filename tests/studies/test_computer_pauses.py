"""Pauses of this computer, which a stopped process feels."""

import os
import signal
import time
from contextlib import closing

from patience import PATIENCE

from apps.studies.computer_pauses import (
    ComputerPauses,
    Pause,
    longest_pause,
)


def test_pauses_outside_the_time_do_not_count():
    pauses = [Pause(1.0, 1.5), Pause(2.0, 2.1), Pause(4.0, 4.9)]
    assert longest_pause(pauses, 1.6, 3.0) == 2.1 - 2.0
    assert longest_pause(pauses, 1.4, 3.0) == 0.5
    assert longest_pause(pauses, 2.2, 3.9) == 0.0


def test_a_process_that_does_not_run_notices_it():
    length = 0.3
    with closing(ComputerPauses()) as computer:
        pid = computer.processes[-1].pid
        assert pid is not None
        begin = time.monotonic()
        while computer.longest(begin, time.monotonic()) < length:
            assert time.monotonic() < begin + PATIENCE
            os.kill(pid, signal.SIGSTOP)
            time.sleep(length)
            os.kill(pid, signal.SIGCONT)
            time.sleep(0.1)
