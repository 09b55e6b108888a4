"""Compiles kernels in worker processes, on idle cores.

With `expect`, a process can declare in advance which kernels it will need. As
soon as it needs one of these kernels that is not on disk, worker processes
compile all of them that are missing. Without such a declaration, workers
compile only kernels with a declared result type, in parallel with the kernels
that call them. The workers write compiled kernels to disk, and this process
loads them. While this process waits for a worker's kernel, it compiles another
kernel from the queue.
"""

import contextlib
import importlib
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Mapping
from threading import Condition, Thread
from typing import Any, NamedTuple

from remosplat_drake.base.kernels.references import Unit, found
from remosplat_drake.base.threads import num_threads

COMPILERS = "REMOSPLAT_COMPILERS"
"""Name of the environment variable that states the largest number of worker
processes."""

extending_modules: list[str] = []
"""Modules that extend Numba's compiler. Worker processes import them before
they compile."""

_REQUESTED, _BEGUN, _ENDED, _READY = range(4)
"""Messages of a worker about a variant (a kernel for certain argument types).
In order, they mean: the worker needs the variant, has begun to compile it, has
compiled it, or is ready for the next variant."""

_USUAL = 1.0
"""Compilation time that is assumed for a variant whose time is unknown [s]."""


class _Compilation:
    """State of compilation: the queue of variants, and the worker processes.

    Attributes:
        changed: Condition that is notified when a variant is requested or has
            been compiled.
        requested: All requested variants.
        waiting: Requested variants that no process has begun to compile, in the
            order of compilation.
        running: Variants that workers compile at present.
        processes: Number of workers.
        idle: Number of idle workers.
        expected: Function that returns the variants that this process will
            need; None if there is no such function, or after its call.
        tell: Function of a worker that sends a message to its parent process;
            None in a process that is not a worker.
        weights: Known compilation times of the expected variants on a reference
            processor [s].
        missing: Compilation times of the variants that were not on disk [s].
        compiled: The variants in `missing` that have been compiled.
        shows: Callback whose argument is True while this process waits for
            kernels, else False.
    """

    def __init__(self):
        self.changed = Condition()
        self.requested: set[Unit] = set()
        self.waiting: dict[Unit, None] = {}
        self.running: set[Unit] = set()
        self.processes = self.idle = 0
        self.expected: Callable[[], Mapping[Any, float]] | None = None
        self.tell: Callable[[int, Unit], None] | None = None
        self.missing: dict[Unit, float] = {}
        self.compiled: set[Unit] = set()
        self.weights: dict[Unit, float] = {}
        self.shows: Callable[[bool], None] | None = None


_state = _Compilation()


def expect(variants: Callable[[], Mapping[Any, float]]) -> None:
    """Declares the variants (kernels for argument types) that will be needed.

    Args:
        variants: Function that returns the variants, in the order of
            compilation, and their compilation times on a reference processor
            [s]. It is called once, when the first variant is missing on disk.
    """
    _state.expected = variants


def show(shows: Callable[[bool], None] | None) -> None:
    """Sets a callback that reports whether this process waits for kernels.

    Args:
        shows: Function that is called with True when the process begins to
            wait, possibly several times, and with False when it no longer
            waits.
    """
    _state.shows = shows


class Count(NamedTuple):
    """Progress of compilation.

    Attributes:
        done: Number of missing kernels that have been compiled.
        total: Number of missing kernels.
        work_done: Compilation time of the kernels counted by `done`, on a
            reference processor [s].
        work: Compilation time of the kernels counted by `total`, on the same
            reference processor [s].
    """

    done: int
    total: int
    work_done: float
    work: float


def count() -> Count:
    """Returns the progress of compilation."""
    with _state.changed:
        missing, compiled = _state.missing, _state.compiled
        done = sum(missing[variant] for variant in compiled)
        work = sum(missing.values())
        return Count(len(compiled), len(missing), done, work)


def rest() -> None:
    """Reports that this process no longer waits for kernels."""
    if _state.shows is not None:
        _state.shows(False)


def _miss(variant: Unit) -> None:
    _state.requested.add(variant)
    _state.missing.setdefault(variant, _state.weights.get(variant, _USUAL))


def request(variant: Unit) -> None:
    """Requests a kernel's variant from the workers, unless it is on disk.

    Args:
        variant: The kernel, for certain argument types.
    """
    if variant in _state.requested or variant.uses is not None:
        return
    _state.requested.add(variant)
    if variant.reference is None or not variant.file or variant.is_kept:
        return
    if _state.tell is not None:
        _state.tell(_REQUESTED, variant)
        return
    with _state.changed:
        _miss(variant)
        _state.waiting[variant] = None
        if not _state.idle and _state.processes < _most():
            _state.processes += 1
            Thread(target=_run_process, daemon=True).start()
        _state.changed.notify_all()


def begin(variant: Unit) -> None:
    """Records that this thread begins to compile a variant of a kernel.

    The caller has found that the variant is not on disk. If another process
    already compiles it, this function waits until that process has finished.

    Args:
        variant: The kernel, for certain argument types.
    """
    if _state.tell is not None:
        _state.tell(_BEGUN, variant)
        return
    expected, _state.expected = _state.expected, None
    if expected is not None:
        _state.weights = dict(expected())
        for other in _state.weights:
            request(other)
    with _state.changed:
        _miss(variant)
    if _state.shows is not None:
        _state.shows(True)
    while True:
        with _state.changed:
            _state.waiting.pop(variant, None)
            if variant not in _state.running:
                return
            if not _state.waiting:
                _state.changed.wait()
                continue
            other = next(iter(_state.waiting))
        # The error is ignored here: a thread that needs the variant compiles it
        # again and raises the error.
        with contextlib.suppress(Exception):
            other.prepare()


def end(variant: Unit) -> None:
    """Records that this thread has compiled a variant, or that this failed."""
    if _state.tell is not None:
        _state.tell(_ENDED, variant)
    with _state.changed:
        _state.compiled.add(variant)


def finish(variant: Unit) -> None:
    """Loads or compiles all variants that a given variant calls.

    Args:
        variant: The given variant, whose own code has been compiled or loaded.
    """
    missing, seen = [variant], set()
    while missing:
        variant = missing.pop()
        if variant in seen:
            continue
        seen.add(variant)
        if variant.uses is None:
            variant.prepare()
        assert variant.uses is not None
        for used in variant.uses:
            request(used)
        missing += variant.uses


def _most() -> int:
    chosen = os.environ.get(COMPILERS, "")
    return int(chosen) if chosen.isdecimal() else num_threads() - 1


def _run_process() -> None:
    """Starts a worker, and sends it variants until it exits."""
    # If the worker exits early, this process compiles the remaining variants.
    try:
        with contextlib.suppress(OSError, EOFError, pickle.PickleError):
            _Process().run()
    finally:
        with _state.changed:
            _state.processes -= 1


class _Process:
    """A worker process and the variants that it compiles."""

    def __init__(self):
        self._process = subprocess.Popen(
            [sys.executable, "-m", f"{__package__}.worker"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env=os.environ
            | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
        )
        self._busy: set[Unit] = set()

    def run(self) -> None:
        """Sends variants from the queue to the worker until it exits."""
        try:
            while True:
                self._compile(self._next())
        finally:
            with _state.changed:
                _state.running -= self._busy
                _state.changed.notify_all()
            self._process.kill()
            self._process.wait()

    def _next(self) -> Unit:
        with _state.changed:
            _state.idle += 1
            while not _state.waiting:
                _state.changed.wait()
            _state.idle -= 1
            variant = next(iter(_state.waiting))
            self._begin(variant)
            return variant

    def _begin(self, variant: Unit) -> None:
        _state.waiting.pop(variant, None)
        _miss(variant)
        _state.running.add(variant)
        self._busy.add(variant)

    def _compile(self, variant: Unit) -> None:
        requests, answers = self._process.stdin, self._process.stdout
        assert requests is not None and answers is not None
        pickle.dump((list(extending_modules), variant.reference), requests)
        requests.flush()
        what = None
        while what != _READY:
            what, reference = pickle.load(answers)
            other = found(reference)
            if other is None:
                continue
            if what == _REQUESTED:
                request(other)
            with _state.changed:
                if what == _BEGUN:
                    self._begin(other)
                elif what in (_ENDED, _READY):
                    self._busy.discard(other)
                    _state.running.discard(other)
                    _miss(other)
                    _state.compiled.add(other)
                    _state.changed.notify_all()


def serve(requests: Any, answers: Any) -> None:
    """Compiles the variants that the parent process requests, until it ends.

    Args:
        requests: File from which this process reads requests.
        answers: File to which this process writes its messages.
    """

    def tell(what, variant):
        if variant.reference is not None:
            pickle.dump((what, variant.reference), answers)
            answers.flush()

    _state.tell = tell
    with contextlib.suppress(EOFError, BrokenPipeError):
        while True:
            modules, reference = pickle.load(requests)
            for module in modules:
                importlib.import_module(module)
            variant = found(reference)
            # An error is ignored here, since the parent process then compiles
            # the variant itself and raises the error.
            with contextlib.suppress(Exception):
                if variant is not None and not variant.is_kept:
                    variant.prepare()
            pickle.dump((_READY, reference), answers)
            answers.flush()
