"""A worker process that compiles kernels for its parent; see `compilation`."""

import os
import signal
import sys

from remosplat_drake.base.kernels import compilation

NICE = 5
"""Nice value of a worker. It is high, so that a running control loop takes
precedence."""

if __name__ == "__main__":
    # Only the parent handles Ctrl-C; this process ends when its parent ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(NICE)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # Text that a module prints must not mix with the answers.
    compilation.serve(sys.stdin.buffer, answers)
