"""A process that compiles kernels for another one; see `compilation`."""

import os
import signal
import sys

from remosplat_drake.base.kernels import compilation

NICE = 5
"""A control loop that waits for nothing comes first."""

if __name__ == "__main__":
    # Ctrl-C is for the other process, upon whose end this one ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICE)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # What a module prints is no answer.
    compilation.serve(sys.stdin.buffer, answers)
