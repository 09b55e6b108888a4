"""Robots that tests import from files of their makers."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.commands.main import main

_EXAMPLES = Path(__file__).parents[1] / "apps" / "examples"


def real_robots() -> Path | None:
    """The folder of the package `example-robot-data`, if it is installed."""
    spec = importlib.util.find_spec("cmeel")
    places = [Path(np.__file__).resolve().parents[1]]
    if spec is not None and spec.origin is not None:
        places.append(Path(spec.origin).resolve().parents[1])
    for place in places:
        robots = place / "cmeel.prefix/share/example-robot-data/robots"
        if robots.is_dir():
            return robots
    return None


def imported(source: Path, out: Path) -> Path:
    """The folder into which a robot is imported, by one command."""
    pytest.importorskip("trimesh", reason="needs the extra robots")
    assert main(["import-robot", str(source), "--out", str(out)]) == 0
    return out


def ridgeback_ur5e(folder: Path) -> Path:
    """The description of an imported UR5e on a Ridgeback."""
    made = imported(_EXAMPLES / "ridgeback_ur5e.dmd.yaml", folder / "made")
    return made / "ridgeback_ur5e.yaml"


def tiago(folder: Path) -> Path:
    """The description of an imported TIAGo; skips without its files."""
    robots = real_robots()
    if robots is None:
        pytest.skip("needs the package example-robot-data")
    source = robots / "tiago_description/robots/tiago_no_hand.urdf"
    return imported(source, folder / "made") / "tiago.yaml"
