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
        elif value is None or isinstance(value, float | int):
            yield place + field.name, value


def test_it_names_all_ingredients_in_their_order(frankie):
    names = [type(part).__name__ for part in default_ingredients(frankie)]
    assert [cell.strip("`") for cell, _ in rows("ingredient")] == names


def test_it_names_all_differences_of_the_gain_sets():
    sets = [dict(values(gain_set(name))) for name in reversed(GAINS)]
    told = {
        re.findall(r"`(.+?)`", field)[0]: numbers
        for field, *numbers in rows("field of `controller`")
    }
    assert told == {
        field: [written(gains[field]) for gains in sets]
        for field in sets[0]
        if len({gains[field] for gains in sets}) > 1
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


def written(value: float | bool | None) -> str:
    if value is None:
        return "–"
    return f"{value:g}" if isinstance(value, float) else str(value).lower()


def in_si(text: str) -> float:
    """A length in metres, and all else in the unit that is written."""
    number, unit = re.findall(r"([\d.]+) ?(.*)", text)[0]
    return float(number) / {"cm": 100, "mm": 1000}.get(unit, 1)
