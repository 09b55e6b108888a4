"""Map files as no program of ours writes them; opens them as a program.

    python map_mutations.py FILE SEED COUNT

makes so many files of one and opens each. A file that is no map must be
refused in one line; of one that is, distances are asked.
"""

import copy
import hashlib
import json
import random
import struct
import sys
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.mapping.store.map_file import KIND, open_map
from remosplat_drake.robot.sphere_model import Spheres

PREFIX = struct.Struct("<8sIIQ32s")
SPHERES = Spheres.at([[0, 0, 0.1], [0.4, 0.1, 0.3], [90, -90, 9]], 0.05)

ODD = (
    *(None, True, False, [], {}, "", "nan", -1, 0, 1, 2, 3, 64, 2**31, 2**53),
    *(2**63, 2**64, 10**400, 1e308, -1e308, 1e-308, float("nan")),
    *(float("inf"), "<f8", "|O", "<f4", "|S8", [2**40, 2**40], "\ud800"),
)


def take_apart(data: bytes) -> tuple[dict, dict[str, bytes]]:
    """A file's header, and the bytes of its arrays."""
    size = PREFIX.unpack(data[: PREFIX.size])[2]
    header = json.loads(data[PREFIX.size :][:size])
    offset, pieces = aligned(PREFIX.size + size), {}
    for name, entry in header["arrays"].items():
        array = np.empty(entry["shape"], entry["dtype"])
        pieces[name] = data[offset : offset + array.nbytes]
        offset += aligned(array.nbytes)
    return header, pieces


def put_together(header: dict, pieces: dict[str, bytes]) -> bytes:
    """A file with correct sums, for any content."""
    text = json.dumps(header).encode()
    body = b""
    for piece in pieces.values():
        body += piece + bytes(aligned(len(piece)) - len(piece))
    start = aligned(PREFIX.size + len(text))
    digest = hashlib.sha256(text).digest()
    front = (KIND.magic, KIND.version, len(text), start + len(body), digest)
    return (PREFIX.pack(*front) + text).ljust(start, b"\0") + body


def with_sums(header: dict, pieces: dict[str, bytes]) -> bytes:
    """The same with the arrays' checksums brought up to date."""
    for name, piece in pieces.items():
        header["arrays"][name]["crc32"] = zlib.crc32(piece)
    return put_together(header, pieces)


def aligned(size: int) -> int:
    """The next multiple of a cache line."""
    return -(-size // 64) * 64


def flip(data: bytes, rng: random.Random) -> bytes:
    """Some other bits."""
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 8])):
        changed[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def cut(data: bytes, rng: random.Random) -> bytes:
    """A part only, or more."""
    return rng.choice([data[: rng.randrange(len(data))], data + b"\0" * 64])


def lie(data: bytes, rng: random.Random) -> bytes:
    """Another value, or none, somewhere in the header."""
    header, pieces = take_apart(data)
    place = rng.choice(list(places(header)))
    inner = header
    for key in place[:-1]:
        inner = inner[key]
    if rng.random() < 0.2:
        del inner[place[-1]]
    else:
        inner[place[-1]] = copy.deepcopy(rng.choice(ODD))
    return put_together(header, pieces)


def places(value: dict | list, above: tuple = ()):
    """The ways to all values within a value."""
    keys = value if isinstance(value, dict) else range(len(value))
    for key in keys:
        yield (*above, key)
        if isinstance(value[key], (dict, list)):
            yield from places(value[key], (*above, key))


def spoil(data: bytes, rng: random.Random) -> bytes:
    """Other numbers in an array: NaN, huge, or links to anywhere."""
    header, pieces = take_apart(data)
    name = rng.choice([name for name, piece in pieces.items() if piece])
    dtype = header["arrays"][name]["dtype"]
    array = np.frombuffer(pieces[name], dtype).copy()
    odd: list[float] = [0, 1, 2, 7, 255]
    if array.dtype.kind == "f":
        odd += [np.nan, np.inf, -np.inf, 3e38, -3e38, 1e-45, -1]
    for _ in range(rng.choice([1, 5, len(array)])):
        array[rng.randrange(len(array))] = rng.choice(odd)
    return with_sums(header, pieces | {name: array.tobytes()})


def reshape(data: bytes, rng: random.Random) -> bytes:
    """An array of another type or shape, with all that follows from it."""
    header, pieces = take_apart(data)
    name = rng.choice(list(pieces))
    dtype = rng.choice(["<f4", "<f8", "<i4", "<i8", "|u1", "|b1", "<i2"])
    shape = [rng.choice([0, 1, 2, 3, 7, 50]) for _ in range(rng.randrange(5))]
    array = np.zeros(shape, dtype)
    header["arrays"][name] |= {"dtype": dtype, "shape": shape}
    return with_sums(header, pieces | {name: array.tobytes()})


MUTATIONS: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    flip,
    cut,
    lie,
    spoil,
    reshape,
)


def main() -> None:
    """See the module."""
    path, seed, count = Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
    original = path.read_bytes()
    changed = path.with_name(f"changed_{path.name}")
    opened = 0
    for i in range(count):
        rng = random.Random(seed + i)
        mutate = rng.choice(MUTATIONS)
        changed.write_bytes(mutate(original, rng))
        print(i, mutate.__name__, flush=True)
        try:
            scene_map = open_map(changed)
        except RemoSplatError as error:
            assert "\n" not in str(error), error
            continue
        answer = scene_map.field.clearances(SPHERES, 5.0)
        assert np.isfinite(answer.distance).all()
        opened += 1
    print("opened", opened)


if __name__ == "__main__":
    main()
