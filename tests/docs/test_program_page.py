"""The tables of the page on the program say what the code has."""

import dataclasses as dc
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from remosplat_drake.controller import ingredients as ing
from remosplat_drake.controller.controller_config import (
    GAINS,
    default_ingredients,
    gain_set,
)

PAGE = Path(__file__).resolve().parents[2] / "docs/theory/program.md"


def rows(first: str) -> list[list[str]]:
    """The rows of the table whose header begins so, cell by cell."""
    table = PAGE.read_text().partition(f"| {first} |")[2].partition("\n\n")[0]
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in table.splitlines()[2:]
    ]


def values(config: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """All numbers and flags of a configuration, with their places in it."""
    for field in dc.fields(config):
        value = getattr(config, field.name)
        if dc.is_dataclass(value):
            yield from values(value, f"{place}{field.name}.")
        elif isinstance(value, float | int):
            yield place + field.name, value


def test_it_names_all_ingredients_in_their_order(frankie):
    names = [type(part).__name__ for part in default_ingredients(frankie)]
    assert [cell.strip("`") for cell, _ in rows("ingredient")] == names


def test_it_names_all_differences_of_the_gain_sets():
    paper, tuned = (dict(values(gain_set(name))) for name in GAINS)
    told = {
        re.findall(r"`(.+?)`", field)[0]: (ours, theirs)
        for field, ours, theirs in rows("field of `controller`")
    }
    assert told == {
        field: (f"{tuned[field]:g}", f"{paper[field]:g}")
        if isinstance(tuned[field], float)
        else (str(tuned[field]).lower(), str(paper[field]).lower())
        for field in tuned
        if tuned[field] != paper[field]
    }


def test_it_tells_the_dampers_distances_and_speeds():
    scene = ing.CollisionDamperConfig()
    joints = ing.JointLimitDamperConfig()
    own, movers = ing.SelfCollisionDamperConfig(), ing.MoverDamperConfig()
    assert [list(map(in_si, row[2:])) for row in rows("damper")] == [
        [scene.influence, scene.stopping, scene.gain],
        [joints.influence, joints.stop, joints.gain],
        [joints.slide_influence, joints.slide_stop, joints.slide_gain],
        [own.influence, own.stopping, own.gain],
        [movers.influence, movers.separation, movers.gain],
    ]


def in_si(text: str) -> float:
    """A length in metres, and all else in the unit that is written."""
    number, unit = re.findall(r"([\d.]+) ?(.*)", text)[0]
    return float(number) / {"cm": 100, "mm": 1000}.get(unit, 1)
