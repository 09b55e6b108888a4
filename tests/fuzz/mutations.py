"""Makes bad files of good ones: of any bytes, of text, and by structure.

A mutation that only flips bits dies at the first checksum. So containers are
opened, changed within and closed again with the sums that belong to them.
"""

import gzip
import io
import json
import random
import re
import struct
import zipfile
import zlib
from collections.abc import Callable

from mapping import map_mutations

Files = dict[str, bytes]
"""What a folder holds, by relative path."""

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_NUMBERS = [
    *(b"0", b"-1", b"-10", b"1", b"1.5", b"nan", b"inf", b"-inf", b"-0.0"),
    *(b"1e308", b"-1e308", b"1e-320", b"1e999", b"2147483648", b"4294967295"),
    *(b"18446744073709551616", b"9223372036854775807", b"1e30", b"10000000"),
    *(b"1" * 30, b"9" * 5000, b"", b"x", b"true", b"null", b"[]", b"{}"),
    *(b'"a"', b"1_000", b"0x10", b"1e", b"+5", b"'1'", b"~", b"!Foo 1"),
]
_WORDS = [
    *(b"\0", b"\xff\xfe", b"\n", b"\r\n", b"\t", b"\x1b[31m", b"{", b"[", b"]"),
    *(b"\xed\xa0\x80", b"../../../etc/passwd", b"/dev/zero", b"&a", b"*a"),
    *(b"<<: *a", b"!!python/object:os.system {}", b"- ", b": ", b"# ", b"|"),
    *(b"a" * 5000, b"[" * 3000, b"{a: " * 500, b"%s%n", b'"', b"'", b"end_"),
]
_PACKED = [
    struct.pack(order + kind, value)
    for order in "<>"
    for kind, values in {
        "H": (0, 1, 0x7FFF, 0x8000, 0xFFFF),
        "I": (0, 1, 255, 2**24, 2**24 + 1, 2**31 - 1, 2**31, 2**32 - 1),
        "Q": (0, 1, 2**32, 2**53, 2**63 - 1, 2**63, 2**64 - 1),
        "f": (float("nan"), float("inf"), -float("inf"), 3e38, 1e-45, -1.0),
        "d": (float("nan"), float("inf"), 1e308, -1e308, 5e-324),
    }.items()
    for value in values
]
_VALUES = [
    *(None, True, False, 0, -1, 1, 2, 0.5, 1e308, -1e308, 1e-320, 10**30),
    *(
        10**400,
        float("nan"),
        float("inf"),
        "",
        "x",
        "1",
        "\0",
        "\ud800",
        "a\nb",
    ),
    *([], {}, [[]], [None], [1, 2, 3], {"a": 1}, [0] * 1000, "é" * 1000, 2**31),
    *(2**32, 2**53, 2**63, 2**64, "../x", "/dev/zero", "nowhere.png"),
]
_PNG = b"\x89PNG\r\n\x1a\n"


def mutated(files: Files, donor: Files, rng: random.Random) -> Files:
    """Some files changed in one to four places.

    Args:
        files: Good ones.
        donor: Good ones of the same format, to splice.
        rng: Decides everything.
    """
    files = dict(files)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        if not files:
            break
        # The small ones say what the large ones are.
        name = min(
            rng.sample(sorted(files), min(2, len(files))),
            key=lambda n: (rng.random() < 0.3, len(files[n])),
        )
        if rng.random() < 0.03:
            _change_folder(files, name, rng)
            continue
        other = donor.get(name) or rng.choice(list(donor.values()))
        files[name] = changed(name, files[name], other, rng)
    return files


def _change_folder(files: Files, name: str, rng: random.Random) -> None:
    """Deletes, empties, copies or renames a file."""
    content = files.pop(name)
    kind = rng.randrange(4)
    if kind == 1:
        files[name] = b""
    elif kind == 2 and files:
        files[rng.choice(sorted(files))] = content
    elif kind == 3:
        files[f"{name}.old"] = content


def changed(name: str, data: bytes, other: bytes, rng: random.Random) -> bytes:
    """A file's content changed in one place."""
    ways: list[Callable] = [_change_bytes]
    by_structure = _structure_of(name, data)
    if by_structure is not None:
        ways += [by_structure] * 3
    if b"\0" not in data[:2000] or data.startswith((b"ply", b"{")):
        ways += [_change_text] * 2
    way = rng.choice(ways)
    try:
        return way(name, data, other, rng)
    except Exception:
        # What an earlier change has left is no such structure any more.
        return _change_bytes(name, data, other, rng)


def _structure_of(name: str, data: bytes) -> Callable | None:
    if data[:1] in (b"{", b"[") and name.endswith(
        (".json", "metadata", ".log", ".jsonl")
    ):
        return _change_json
    if name.endswith(".rsmap"):
        return _change_map
    if data.startswith(b"PK\x03\x04"):
        return _change_torch if name.endswith(".pt") else _change_zip
    if data.startswith(b"\x1f\x8b"):
        return _change_gzip
    if data.startswith(_PNG):
        return _change_png
    if data.startswith(b"bvx"):
        return _change_lzfse
    if name.endswith(".webp"):
        return _other_webp
    return None


def _change_bytes(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    content = bytearray(data)
    # Headers decide more than what follows.
    size = len(content)
    at = (
        rng.randrange(min(size, 400) if rng.random() < 0.5 else size or 1)
        if (size)
        else 0
    )
    length = rng.choice((1, 2, 4, 8, 32, 256, max(1, size // 2)))
    kind = rng.randrange(8)
    if kind == 0 and size:
        content[at] ^= 1 << rng.randrange(8)
    elif kind == 1 and size:
        content[at] = rng.choice((0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)))
    elif kind == 2:
        del content[at:]
    elif kind == 3:
        content[at:at] = rng.choice((bytes(length), rng.randbytes(length)))
    elif kind == 4:
        del content[at : at + length]
    elif kind == 5:
        content[at:at] = content[at : at + length]
    elif kind == 6:
        cut = rng.randrange(len(other) + 1)
        content[at:] = other[cut:]
    else:
        word = rng.choice(_PACKED)
        content[at : at + len(word)] = word
    return bytes(content)


def _change_text(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    kind = rng.randrange(6)
    numbers = list(_NUMBER.finditer(data[: 2**16]))
    if kind < 3 and numbers:
        chosen = rng.choice(numbers)
        new = rng.choice(_NUMBERS)
        return data[: chosen.start()] + new + data[chosen.end() :]
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    if kind == 3:
        lines[i : i + 1] = rng.choice(([], [lines[i]] * 2, [b"  " + lines[i]]))
    elif kind == 4:
        lines[i], lines[j] = lines[j], lines[i]
    else:
        at = rng.randrange(len(lines[i]) + 1)
        lines[i] = lines[i][:at] + rng.choice(_WORDS) + lines[i][at:]
    return b"\n".join(lines)


def _change_json(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    """One place of a document; a log's is its first line."""
    head, newline, tail = data, b"", b""
    if name.endswith((".log", ".jsonl")):
        head, newline, tail = data.partition(b"\n")
    document = [json.loads(head)]
    places: list[tuple] = []
    _gather(document, places)
    container, key = rng.choice(places)
    kind = rng.randrange(6)
    if kind < 3:
        container[key] = rng.choice(_VALUES)
    elif kind == 3:
        container[key] = rng.choice(places)[0]
        if container[key] is document or _holds(container[key], container):
            container[key] = None
    elif kind == 4:
        del container[key]
        document = document or [None]
    else:
        marker = "@nested@"
        depth = rng.choice((5, 40, 400, 5000))
        container[key] = marker
        text = json.dumps(document[0])
        deep = rng.choice(("[" * depth + "]" * depth, '{"a":' * depth))
        return text.replace(f'"{marker}"', deep).encode() + newline + tail
    text = json.dumps(document[0])
    if rng.random() < 0.1:
        text = text.replace("{", '{"w": 1, "w": 2, ', 1)
    return text.encode() + newline + tail


def _gather(container, places: list[tuple]) -> None:
    """All places (container, key) of a document."""
    keys = container if isinstance(container, dict) else range(len(container))
    for key in list(keys):
        places.append((container, key))
        if isinstance(container[key], (dict, list)):
            _gather(container[key], places)


def _holds(outer, inner) -> bool:
    places: list[tuple] = [(None, None)]
    if isinstance(outer, (dict, list)):
        _gather(outer, places)
    return outer is inner or any(
        c is not None and c[k] is inner for c, k in places
    )


def _change_map(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    """As the maps' own tests do: the sums fit what the file says."""
    return rng.choice(map_mutations.MUTATIONS)(data, rng)


def _change_zip(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        members = {n: archive.read(n) for n in archive.namelist()}
    chosen = rng.choice(sorted(members))
    kind = rng.randrange(10)
    if kind == 0:
        del members[chosen]
    elif kind == 1:
        members[chosen + "x"] = members.pop(chosen)
    elif kind == 2:
        members[chosen] = bytes(rng.choice((0, 1, 10**6, 10**8)))
    else:
        content = rng.choice(list(members.values()))
        members[chosen] = changed(chosen, members[chosen], content, rng)
    packing = rng.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))
    return _zipped(members, packing)


def _zipped(members: Files, packing: int) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", packing) as archive:
        for name, data in members.items():
            # ZipInfo's own date makes equal cases equal files.
            archive.writestr(zipfile.ZipInfo(name), data, packing)
    return content.getvalue()


def _change_gzip(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    content = gzip.decompress(data)
    if rng.random() < 0.1:
        content += bytes(rng.choice((1, 10**6, 10**8)))
    else:
        content = _change_bytes(name, content, content, rng)
    return gzip.compress(content, 1, mtime=0)


def _change_lzfse(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    import lzfse

    if rng.random() < 0.2:
        content = bytes(rng.choice((0, 1, 10**6, 10**8)))
    else:
        try:
            content = lzfse.decompress(data)
        except lzfse.error as error:
            raise ValueError from error
        content = _change_bytes(name, content, content, rng)
    return lzfse.compress(content)


def _change_png(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    """Another header with its sum, or another picture altogether."""
    if rng.random() < 0.5:
        mode = rng.choice(("L", "RGB", "RGBA", "I;16", "P", "1", "LA"))
        return _picture("PNG", mode, rng)
    header = bytearray(data[16:29])
    at = rng.choice((0, 4, 8, 9, 10, 11, 12))
    if at < 8:
        sizes = (0, 1, 3, 7000, 9000, 30000, 2**31 - 1, 2**32 - 1)
        header[at : at + 4] = struct.pack(">I", rng.choice(sizes))
    else:
        header[at] = rng.randrange(20)
    crc = struct.pack(">I", zlib.crc32(b"IHDR" + header))
    return data[:16] + bytes(header) + crc + data[33:]


def _other_webp(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    if rng.random() < 0.5:
        return _change_bytes(name, data, other, rng)
    return _picture("WEBP", rng.choice(("RGBA", "RGB")), rng)


def _picture(kind: str, mode: str, rng: random.Random) -> bytes:
    """An even picture; a large one packs very tightly."""
    from PIL import Image

    sides = (1, 2, 5, 24, 32, 200, 4000, 7000)
    size = rng.choice(sides), rng.choice(sides)
    content = io.BytesIO()
    options = {"lossless": True} if kind == "WEBP" else {}
    Image.new(mode, size).save(content, kind, **options)
    return content.getvalue()


def _change_torch(
    name: str, data: bytes, other: bytes, rng: random.Random
) -> bytes:
    if rng.random() < 0.5:
        return _change_zip(name, data, other, rng)
    import torch

    content = torch.load(io.BytesIO(data), weights_only=True)
    splats = content.get("splats", content)
    key = rng.choice(sorted(splats))
    tensor = splats[key]
    splats[key] = rng.choice(
        (
            lambda: tensor.reshape(-1)[0],
            lambda: tensor[:0],
            lambda: tensor[:, None] if tensor.ndim else tensor,
            lambda: tensor.to_sparse(),
            lambda: tensor.to("meta"),
            lambda: tensor.int(),
            lambda: tensor.bool(),
            lambda: tensor.to(torch.complex64),
            lambda: tensor.double() * 1e300,
            lambda: tensor.to(torch.float8_e5m2),
            lambda: tensor * float("nan"),
            lambda: tensor.reshape(-1)[:1].expand(10**9),
            lambda: torch.nn.Parameter(tensor),
            lambda: tensor.reshape(-1),
            lambda: [tensor],
            lambda: "tensor",
        )
    )()
    changed_file = io.BytesIO()
    torch.save(content, changed_file)
    return changed_file.getvalue()
