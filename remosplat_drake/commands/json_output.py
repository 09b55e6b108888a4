"""The flag `--json`, which prints a command's results for other programs."""

import argparse
import dataclasses as dc
import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically


def add_json_argument(parser: argparse.ArgumentParser) -> None:
    """Declares the flag `--json`."""
    parser.add_argument(
        "--json",
        action="store_true",
        help="print only one JSON document to stdout",
    )


def print_json(document: Any) -> None:
    """Prints a document as JSON; see `plain` for the supported types."""
    print(json_text(document))


def write_json(path: Path, document: Any) -> None:
    """Writes a document to a JSON file; see `plain` for the supported types.

    Raises:
        FileError: The file cannot be written.
    """
    write_atomically(path, json_text(document) + "\n")


def json_text(document: Any) -> str:
    """Returns a document as JSON text; see `plain` for the supported types."""
    return json.dumps(plain(document), indent=1, ensure_ascii=False)


def plain(value: Any) -> Any:
    """Converts dataclasses, arrays, paths and numbers to JSON's types.

    Infinities and NaN become null.

    Args:
        value: An object of these types, or a list, tuple or mapping of them.
    """
    if dc.is_dataclass(value) and not isinstance(value, type):
        fields = dc.fields(value)
        return {f.name: plain(getattr(value, f.name)) for f in fields}
    if isinstance(value, dict):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
