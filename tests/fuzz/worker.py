"""The process in which cases run: it may crash, hang or swell.

Reads lines `format seed` and answers each with a line of JSON. The kernel
ends it when a case takes too much processor time; the campaign, when one
waits for ever. Memory is what the resident set grew by at its highest.
"""

import gc
import json
import os
import random
import resource
import shutil
import sys
import traceback
import warnings
from pathlib import Path

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError

from .formats import FORMATS, Format
from .mutations import Files, mutated
from .unpacked import unpacked_size

MEMORY_BASE = 64 * 2**20
MEMORY_MULTIPLE = 50
UNPACKED_MULTIPLE = 16
"""A reader may take so many bytes, so many for each byte of its files, and so
many for each that these unpack to; see `unpacked_size`."""

CPU_LIMIT = 20
"""Processor time of a case [s]; good files take hundredths."""

_SPARE_ADDRESSES = 4 * 2**30
"""Address space beyond what a case may use, for a machine's sake."""


def case_of(corpus: dict[str, Files], name: str, seed: int) -> Files:
    """The files of a case; seed 0 is the good files."""
    good = corpus[name]
    if seed == 0:
        return good
    rng = random.Random(f"{name} {seed}")
    # A foreign file is spliced in now and then.
    donor = rng.choice((name, name, name, *sorted(corpus)))
    return mutated(good, corpus[donor], rng)


def corpus_of(formats: dict[str, Format], folder: Path) -> dict[str, Files]:
    """Good files of each format whose optional packages are installed."""
    corpus = {}
    for name, format_ in formats.items():
        place = folder / name
        place.mkdir(parents=True)
        try:
            format_.make(place)
        except (ImportError, MissingExtraError):
            continue
        corpus[name] = {
            str(path.relative_to(place)): path.read_bytes()
            for path in sorted(place.rglob("*"))
            if path.is_file()
        }
    return corpus


def write_case(folder: Path, files: Files) -> None:
    """Puts a case's files into a folder, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def judged(format_: Format, folder: Path, files: Files) -> dict[str, str]:
    """Reads a case's files, which lie in a folder; says how that went."""
    gc.collect()  # Quick: all that the modules hold is frozen.
    size = sum(map(len, files.values()))
    unpacked = sum(unpacked_size(data) for data in files.values())
    allowed = MEMORY_BASE + MEMORY_MULTIPLE * size
    allowed += UNPACKED_MULTIPLE * unpacked
    before = _reset_peak()
    _limit(allowed)
    answer = _answer(format_, folder)
    grown = _peak() - before
    if grown > allowed and answer["kind"] in ("read", "refused"):
        text = (
            f"{grown / 2**20:.0f} MiB for {size} bytes that hold {unpacked}; "
            f"{allowed / 2**20:.0f} MiB are allowed ({answer['text']})"
        )
        return {"kind": "memory", "text": text, "trace": ""}
    return answer


def _answer(format_: Format, folder: Path) -> dict[str, str]:
    try:
        with warnings.catch_warnings():
            # A line about an overflow beside the error is one too many.
            warnings.simplefilter("error", RuntimeWarning)
            format_.read(folder)
    except MissingExtraError as error:
        return {"kind": "missing", "text": str(error), "trace": ""}
    except RemoSplatError as error:
        return {"kind": "refused", "text": str(error)[:300], "trace": ""}
    except Exception as error:
        # The reader's own error is behind the last resort's.
        cause = error.__cause__ or error
        frame = traceback.extract_tb(cause.__traceback__)[-1]
        place = f"{Path(frame.filename).name}:{frame.lineno}"
        text = f"{type(cause).__name__} at {place}: {cause}"
        return {
            "kind": "traceback",
            "text": text[:300],
            "trace": "".join(traceback.format_exception(error))[-6000:],
        }
    return {"kind": "read", "text": "", "trace": ""}


def _limit(memory: int) -> None:
    """Lets the kernel end a case that goes far beyond its bounds."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    cpu = int(used.ru_utime + used.ru_stime) + 1 + CPU_LIMIT
    hard = resource.getrlimit(resource.RLIMIT_CPU)[1]
    resource.setrlimit(resource.RLIMIT_CPU, (cpu, hard))
    addresses = _status("VmSize") + memory + _SPARE_ADDRESSES
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (addresses, hard))


def _reset_peak() -> int:
    """Lets the kernel measure a new peak; returns what is resident now."""
    Path("/proc/self/clear_refs").write_text("5")
    return _status("VmRSS")


def _peak() -> int:
    return _status("VmHWM")


def _status(field: str) -> int:
    """A size of this process, from the kernel [bytes]."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{field}:"):
            return 1024 * int(line.split()[1])
    raise OSError(f"the kernel tells no {field}")


def serve(
    formats: dict[str, Format], folder: Path, rehearse: bool = True
) -> None:
    """Answers until the campaign has no more cases.

    Args:
        formats: By name.
        folder: For the files.
        rehearse: Whether good files are read once before the first case, so
            that modules and kernels are loaded.
    """
    answers = os.fdopen(os.dup(1), "w")
    # What libraries print is no answer.
    os.dup2(2, 1)
    corpus = corpus_of(formats, folder / "corpus")
    for name, files in corpus.items() if rehearse else ():
        write_case(folder / "case", files)
        _answer(formats[name], folder / "case")
    gc.collect()
    gc.freeze()
    print(json.dumps({"kind": "ready"}), file=answers, flush=True)
    for line in sys.stdin:
        name, seed = line.split()
        answer = {"kind": "missing", "text": "", "trace": ""}
        if name in corpus:
            files = case_of(corpus, name, int(seed))
            write_case(folder / "case", files)
            answer = judged(formats[name], folder / "case", files)
        print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    serve(FORMATS, Path(sys.argv[1]))
