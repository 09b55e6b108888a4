"""Checks this computer's clock, priorities and socket buffers."""

import ctypes
import re
import resource
import shutil
import subprocess
from pathlib import Path

from remosplat_drake.base.real_time import DRIVER_PRIORITY
from remosplat_drake.hardware.doctor.finding import (
    ADVICE,
    Finding,
    judged,
)

CLOCK_ERROR = 1e-3
"""Largest permitted error of a clock [s]."""

BUFFER = 1 << 21
"""Size of the receive buffer of a socket for images [bytes]. It has space for
three images, since their fragments may arrive faster than they are read."""

_TIMEX = 512
"""Buffer size that exceeds a `struct timex` on every platform [bytes]."""

_TIME_ERROR = 5
"""Return value of `adjtimex` for a clock that is not synchronised."""

_SYSCTL = Path("/proc/sys")


def check_clock() -> Finding:
    """Checks this computer's clock with chrony, or else with the kernel."""
    wanted = f"within {1e3 * CLOCK_ERROR:g} ms of NTP or PTP"
    remedy = "install chrony on both computers, and let one follow the other"
    if shutil.which("chronyc") is None:
        follows = kernel_clock_follows()
        return judged(
            "clock",
            follows,
            found="the kernel's clock is synchronised"
            if follows
            else "the kernel's clock is not synchronised",
            wanted=wanted,
            source="adjtimex, since chronyc is not installed",
            remedy=remedy,
            otherwise=ADVICE,
        )
    told = subprocess.run(
        ["chronyc", "tracking"], capture_output=True, text=True, check=False
    )
    offset = clock_offset(told.stdout)
    return judged(
        "clock",
        offset is not None and abs(offset) <= CLOCK_ERROR,
        found="chrony follows no clock"
        if offset is None
        else f"{1e3 * offset:.3f} ms off",
        wanted=wanted,
        source="chronyc tracking",
        remedy=remedy,
        otherwise=ADVICE,
    )


def kernel_clock_follows() -> bool:
    """Returns whether the kernel's clock is synchronised to another clock."""
    # With a `struct timex` of zeros, the call only reads the state.
    timex = ctypes.create_string_buffer(_TIMEX)
    state = ctypes.CDLL(None).adjtimex(ctypes.byref(timex))
    return 0 <= state < _TIME_ERROR


def clock_offset(tracking: str) -> float | None:
    """Reads the offset from the output of `chronyc tracking` [s].

    Args:
        tracking: The text.

    Returns:
        The time by which the clock is ahead [s]; None if chrony follows no
        other clock.
    """
    match = re.search(
        r"^System time\s*: ([\d.]+) seconds (fast|slow)", tracking, re.M
    )
    follows = re.search(r"^Leap status\s*: Normal", tracking, re.M)
    if match is None or follows is None:
        return None
    return float(match[1]) * (1 if match[2] == "fast" else -1)


def check_priority() -> Finding:
    """Checks whether processes may have real-time priorities."""
    _, hard = resource.getrlimit(resource.RLIMIT_RTPRIO)
    is_unlimited = hard == resource.RLIM_INFINITY
    capabilities = Path("/proc/self/status").read_text()
    match = re.search(r"^CapEff:\s*([0-9a-f]+)", capabilities, re.M)
    # Bit 23 is CAP_SYS_NICE, which the root user has.
    is_root = match is not None and bool(int(match[1], 16) >> 23 & 1)
    return judged(
        "real-time priority",
        is_unlimited or is_root or hard >= DRIVER_PRIORITY,
        found="any" if is_unlimited or is_root else f"up to {hard}",
        wanted=f"{DRIVER_PRIORITY} or more",
        source="RLIMIT_RTPRIO and CAP_SYS_NICE",
        remedy="`@robot - rtprio 20` in /etc/security/limits.conf, then log in"
        " again",
        otherwise=ADVICE,
    )


def check_buffers(has_camera: bool) -> Finding:
    """Checks that socket buffers are large enough for waiting packets.

    Args:
        has_camera: Whether images are also received.
    """
    path = _SYSCTL / "net/core/rmem_default"
    size = int(path.read_text())
    wanted = BUFFER if has_camera else 1 << 17
    return judged(
        "socket buffers",
        size >= wanted,
        found=f"{size} bytes",
        wanted=f"{wanted} bytes or more",
        source=str(path),
        remedy=f"`sysctl -w net.core.rmem_max={wanted}"
        f" net.core.rmem_default={wanted}`",
        otherwise=ADVICE,
    )
