"""The generated reference tells of every field and flag what the code does."""

import argparse
import dataclasses as dc
import re
from typing import Annotated

import pytest
from annotated_types import Ge, Gt, Interval, Len
from command_flags import make_parser, reference_of_commands
from scenario_fields import field_rows, reference_of

import remosplat_drake as rs
from remosplat_drake.app.scenario import Scenario
from remosplat_drake.base.ranges import (
    Config,
    OneOf,
    Unbounded,
    field_types,
    split,
)
from remosplat_drake.commands.main import COMMANDS


@dc.dataclass
class Wheel(Config):
    """A wheel. Round."""

    # Distance from the hub to the ground [m].
    radius: Annotated[float, Interval(gt=0, le=2)] = 0.5


@dc.dataclass
class Sledge(Config):
    """Runs without wheels."""

    load: Annotated[float, Unbounded("it is not known")] = 1.0


@dc.dataclass
class Cart(Config):
    """A cart.

    It is drawn.
    """

    wheel: Wheel = dc.field(default_factory=Wheel)
    spare: Wheel | None = None
    other: Wheel | Sledge = dc.field(default_factory=Sledge)
    # Its animal: a horse, or
    # an ox.
    animal: Annotated[str, OneOf(("horse", "ox"))] = "ox"
    # Lengths of the left and the right shaft [m].
    left: Annotated[float, Gt(0)] = 1.0
    right: Annotated[float, Gt(0)] = 1.5
    is_empty: bool = True
    # Weights of what is on it [kg], heaviest first.
    loads: Annotated[list[Annotated[float, Ge(0)]], Len(0, 4)] = dc.field(
        default_factory=lambda: [2.5]
    )
    source: str = dc.field(default="", metadata={"yaml": False})


ROWS = {row.name: row for row in field_rows(Cart)}


def test_a_number_has_default_range_and_unit():
    (row,) = field_rows(Wheel)
    assert row.kind == "number"
    assert row.default == "`0.5`"
    assert row.range == "(0, 2]"
    assert row.unit == "m"
    assert row.meaning == "Distance from the hub to the ground."


def test_names_are_listed_and_comments_joined():
    assert ROWS["animal"].range == "`horse`, `ox`"
    assert ROWS["animal"].meaning == "Its animal: a horse, or an ox."


def test_a_pair_shares_its_comment_and_nothing_else_does():
    assert ROWS["left"].meaning == ROWS["right"].meaning != ""
    assert ROWS["right"].unit == "m"
    assert ROWS["is_empty"].meaning == ""


def test_lists_tell_of_their_items():
    loads = ROWS["loads"]
    assert loads.kind == "list of numbers"
    assert loads.range == "0 to 4 of them; each ≥ 0"
    assert loads.default == "`[2.5]`"
    assert loads.unit == "kg"


def test_configurations_are_links_and_tags_where_one_must_choose():
    assert ROWS["wheel"].kind == ROWS["spare"].kind == "[Wheel](#Wheel)"
    assert ROWS["spare"].default == "absent"
    assert ROWS["other"].kind == "[`!Wheel`](#Wheel) or [`!Sledge`](#Sledge)"
    assert ROWS["other"].default == "`!Sledge`"
    assert field_rows(Sledge)[0].range == "any: it is not known"


def test_what_no_file_sets_is_left_out():
    assert "source" not in ROWS


def test_the_reference_tells_where_each_class_is_found():
    text = reference_of(Cart)
    assert text.count("\n## ") == 2
    assert "Found at `wheel`, `spare`, `other`." in text
    assert "It is drawn" not in text


def test_every_field_of_a_scenario_is_there():
    text = reference_of(Scenario)
    for schema in configs_of(Scenario):
        section = text.partition(f"{{ #{schema.__name__} }}")[2]
        section = section.partition("\n## ")[0]
        for field in dc.fields(schema):
            shown = f"| `{field.name}` |" in section
            assert shown == (field.metadata.get("yaml") is not False)


def configs_of(schema: type) -> set[type]:
    found = {schema}
    for row in field_rows(schema):
        for config in row.configs:
            found |= configs_of(config)
    return found


@pytest.mark.parametrize(
    "schema", sorted(configs_of(Scenario), key=lambda schema: schema.__name__)
)
def test_every_number_has_a_range_and_every_field_a_meaning(schema):
    for row in field_rows(schema):
        base, _ = split(field_types(schema)[row.name])
        assert row.range or base not in (int, float)
        assert row.meaning, row.name


@pytest.mark.parametrize("command", COMMANDS)
def test_every_flag_of_a_command_is_there(command):
    section = reference_of_commands().partition(f"## {command}\n")[2]
    section = section.partition("\n## ")[0]
    for action in make_parser(command)._actions:
        if not isinstance(action, argparse._HelpAction):
            name = (action.option_strings or [action.metavar or action.dest])[0]
            assert f"| `{name}" in section


def test_every_public_name_is_there():
    pytest.importorskip("mkdocs")
    from reference import reference_of_api

    names = re.findall(r"^::: .*\.(\w+)$", reference_of_api(), re.M)
    assert names == [name for name in rs.__all__ if name[0] != "_"]
