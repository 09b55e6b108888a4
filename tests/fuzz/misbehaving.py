"""A worker whose readers do all that none may, to see it noticed."""

import os
import sys
import time
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import FileError

from . import worker
from .formats import Format


def _make(folder: Path) -> None:
    (folder / "file").write_bytes(b"content")


def _raise(folder: Path) -> None:
    raise ValueError("a defect")


def _warn(folder: Path) -> None:
    np.float32(1e38) * np.float32(1e38)


def _refuse(folder: Path) -> None:
    raise FileError(folder, "is no good")


def _spin(folder: Path) -> None:
    while True:
        pass


def _sleep(folder: Path) -> None:
    time.sleep(3600)


def _swell(folder: Path) -> int:
    return len(np.ones(10**8, np.uint8))


def _swell_beyond_all_measure(folder: Path) -> np.ndarray:
    return np.ones(10**12, np.uint8)


READERS = {
    "good": lambda folder: (folder / "file").read_bytes(),
    "refuse": _refuse,
    "raise": _raise,
    "warn": _warn,
    "crash": lambda folder: os.abort(),
    "exit": lambda folder: os._exit(0),
    "spin": _spin,
    "sleep": _sleep,
    "swell": _swell,
    "swell beyond": _swell_beyond_all_measure,
}

if __name__ == "__main__":
    worker.CPU_LIMIT = 1
    formats = {name: Format(_make, read) for name, read in READERS.items()}
    worker.serve(
        {name.replace(" ", "-"): f for name, f in formats.items()},
        Path(sys.argv[1]),
        rehearse=False,
    )
