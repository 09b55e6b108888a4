"""Valid YAML, and the errors about the rest."""

import dataclasses as dc
from pathlib import Path

import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.strict_yaml import dump, entries, load_strict
from remosplat_drake.base.yaml_nodes import MOST_BYTES


@dc.dataclass
class Wheel:
    radius: float = 0.1


@dc.dataclass
class Leg:
    length: float = 1.0
    joints: int = 2


@dc.dataclass
class Robot:
    speed: float = 0.5
    count: int = 3
    active: bool = True
    name: str = "robot"
    model: Path = Path("robot.urdf")
    home: list[float] = dc.field(default_factory=lambda: [1.0, 2.0])
    spare: Wheel | None = None
    support: Wheel | Leg = dc.field(default_factory=Wheel)
    supports: list[Wheel | Leg] = dc.field(default_factory=list)
    parts: dict[str, Leg] = dc.field(default_factory=dict)


@pytest.fixture
def load(tmp_path):
    """Writes a text to a file and loads that into a `Robot`."""

    def load_text(text: str, **kwargs) -> Robot:
        path = tmp_path / "robot.yaml"
        path.write_text(text)
        return load_strict(Robot, path, **kwargs)

    return load_text


def test_every_kind_of_field_loads(load):
    text = """
    speed: 2
    count: 7
    active: false
    name: "2"
    model: a/b.urdf
    home: [1, 2.5, -1e-3]
    spare: {radius: 0.3}
    support: !Leg {length: 2}
    supports: [!Leg {joints: 4}, {radius: 1}]
    parts: {front: {length: 3}, rear: {}}
    """
    assert load(text) == Robot(
        speed=2.0,
        count=7,
        active=False,
        name="2",
        model=Path("a/b.urdf"),
        home=[1.0, 2.5, -1e-3],
        spare=Wheel(0.3),
        support=Leg(length=2.0),
        supports=[Leg(joints=4), Wheel(1.0)],
        parts={"front": Leg(length=3.0), "rear": Leg()},
    )


def test_an_empty_mapping_is_all_defaults(load):
    assert load("{}") == Robot()


def test_null_is_allowed_where_the_field_is_optional(load):
    assert load("spare: null").spare is None


@pytest.mark.parametrize("text", ["1e-3", "1E-3", "0.001", "+.001", "1.0e-3"])
def test_spellings_of_a_number(load, text):
    assert load(f"speed: {text}").speed == 0.001


@pytest.mark.parametrize(
    ("text", "field", "problem"),
    [
        ("sped: 1", "sped", "did you mean 'speed'?"),
        ("support: {radios: 1}", "support.radios", "did you mean 'radius'?"),
        ("speed: fast", "speed", "expected a number, got 'fast'"),
        ('speed: "1"', "speed", "remove the quotes"),
        ("speed: [1]", "speed", "expected a number"),
        ("speed: true", "speed", "expected a number"),
        ("speed:", "speed", "expected a number"),
        ("speed: 1:30", "speed", "expected a number"),
        ("speed: .nan", "speed", "must be finite"),
        ("speed: nan", "speed", "must be finite"),
        ("speed: -.inf", "speed", "must be finite"),
        ("speed: 1e999", "speed", "must be finite"),
        ("speed: 012", "speed", "octal"),
        ("count: 010", "count", "octal"),
        ("count: 1.5", "count", "expected a whole number"),
        ("count: '3'", "count", "remove the quotes"),
        ("active: 1", "active", "expected true or false"),
        ("active: 'true'", "active", "remove the quotes"),
        ("name: 3", "name", "put it in quotes"),
        ("name: no", "name", "put it in quotes"),
        ("name:", "name", "expected text"),
        ("model: 3", "model", "expected a path"),
        ("home: 3", "home", "expected a list"),
        ("home: [1, x]", "home[1]", "expected a number"),
        ("home: [1, .inf]", "home[1]", "must be finite"),
        ("support: 3", "support", "expected a mapping"),
        ("support: !Tail {}", "support", "unknown tag 'Tail'; valid: Leg"),
        ("support: !Leg", "support", "expected a mapping"),
        ("support: {length: 1}", "support.length", "valid: radius"),
        ("supports: [{}, !Tail {}]", "supports[1]", "unknown tag"),
        ("supports: !Leg []", "supports", "must not have a tag, got '!Leg'"),
        ("spare: !Wheel {}", "spare", "must not have a tag, got '!Wheel'"),
        ("speed: !Fast 3", "speed", "must not have a tag, got '!Fast'"),
        ("parts: {a: {joints: x}}", "parts.a.joints", "whole number"),
        ("parts: {a: {}, a: {}}", "parts.a", "appears twice"),
        ("speed: 1\nspeed: 2", "speed", "appears twice"),
        ("[1, 2]", "the document", "expected a mapping"),
        ("? [a]\n: 1", "the document", "must be plain text"),
        ("1: 2", "1", "a key must be text, got '1' (put it in quotes)"),
        ("no: 2", "no", "a key must be text"),
        ("<<: {speed: 1}", "<<", "a key must be text"),
        ("parts: {1: {}}", "parts.1", "a key must be text"),
        ("count: 1:30", "count", "expected a whole number, got '1:30'"),
        ("count: 1e3", "count", "expected a whole number, got '1e3'"),
        ("count: 1" + 5000 * "0", "count", "expected a whole number, got '1"),
        ("speed: 1" + 5000 * "0", "speed", "must be finite, got '1"),
        ("speed: " + 9000 * "x", "speed", "expected a number, got 'xxx"),
        ("home: {a: 1}", "home", "expected a list"),
        ("model: [a]", "model", "expected a path"),
        ("active: !!bool x", "active", "expected true or false, got 'x'"),
        ("count: !!int x", "count", "expected a whole number, got 'x'"),
        ("active: {}", "active", "expected true or false"),
        ("parts: []", "parts", "expected a mapping"),
    ],
)
def test_bad_fields_are_named(load, text, field, problem):
    with pytest.raises(FieldError) as caught:
        load(text)
    assert caught.value.field == field
    assert problem in caught.value.problem
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_the_line_is_named(load):
    with pytest.raises(FieldError, match=r"robot\.yaml:4: support\.radius:"):
        load("speed: 1\n\nsupport:\n  radius: wide\n")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "is empty"),
        ("# Only a comment.\n", "is empty"),
        ("home: [1", "not YAML"),
        ("\tspeed: 1", "not YAML"),
        ("speed: 1\n---\nspeed: 2", "not YAML"),
        ("home: " + 3000 * "[" + 3000 * "]", "nested more than 40 levels deep"),
        (3000 * "{a: " + "1" + 3000 * "}", "nested more than 40 levels deep"),
        (3000 * "- ", "nested more than 40 levels deep"),
        ('name: "\\UFFFFFFFF"', "not YAML"),
        ("%YAML 1." + 5000 * "9" + "\n---\na: 1", "not YAML"),
        ("home: *nowhere", "not YAML"),
        (
            "supports: &a [*a]",
            "an alias refers to a value that contains the alias",
        ),
        ("name: a\x00b", "not YAML"),
    ],
)
def test_bad_documents_are_named(load, text, problem):
    with pytest.raises(FileError, match=problem) as caught:
        load(text)
    assert "robot.yaml" in str(caught.value)
    assert "\n" not in str(caught.value)


def laughs(levels: int) -> str:
    """A few lines that stand for 9 ** levels values."""
    lines = ["parts: {}", "a0: &a0 {length: 1}"]
    for i in range(levels):
        lines.append(f"a{i + 1}: &a{i + 1} [{', '.join(9 * [f'*a{i}'])}]")
    return "\n".join(lines)


def test_aliases_do_not_multiply_without_end(load):
    """A list of them all would not fit into any memory."""
    with pytest.raises(FileError, match="aliases expand to more than"):
        load(laughs(50))


def test_aliases_are_welcome(load):
    robot = load(
        "support: &leg !Leg {length: 3}\nsupports: [*leg, *leg]\n"
        "home: &h [1, 2]\n"
    )
    assert robot.supports == [Leg(3.0), Leg(3.0)]
    # Objects of their own.
    assert robot.supports[0] is not robot.supports[1]


def test_whole_numbers_beyond_64_bits_are_numbers(load):
    assert load("count: 100000000000000000000").count == 10**20
    assert load("count: 0x1F").count == 31
    assert load("count: -1_000").count == -1000


def test_a_huge_file_is_refused(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_text("name: " + (MOST_BYTES + 1) * "x")
    with pytest.raises(FileError, match="larger than 8 MiB"):
        load_strict(Robot, path)
    with pytest.raises(FileError, match="larger than 8 MiB"):
        load_strict(Robot, Path("/dev/zero"))


def test_an_override_may_choose_another_class_or_nothing(load):
    text = "support: !Leg {length: 3}\nspare: {radius: 0.3}\n"
    robot = load(text, override="{support: {radius: 0.5}, spare: null}")
    assert (robot.support, robot.spare) == (Wheel(0.5), None)
    robot = load(text, override="spare: {}")
    assert robot.spare == Wheel(0.3)
    robot = load(text, override="support: !Wheel {}")
    assert robot.support == Wheel()


def test_lists_and_mappings_are_replaced(load):
    text = "home: [1, 2, 3]\nparts: {a: {length: 3}}\n"
    robot = load(text, override="{home: [4], parts: {b: {}}}")
    assert (robot.home, robot.parts) == ([4.0], {"b": Leg()})


def test_what_is_written_out_is_read_back(tmp_path):
    robot = Robot(
        speed=1e-7,
        name="no",
        model=Path("a: b"),
        home=[0.1 + 0.2],
        support=Leg(2.5),
        supports=[Wheel(0.3), Leg(joints=-1)],
        parts={"1": Leg(), "on: off": Leg(1e300)},
    )
    path = tmp_path / "out.yaml"
    path.write_text(dump("Odd: name", robot))
    assert load_strict(Robot, path, "Odd: name") == robot


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match=r"none\.yaml: No such file"):
        load_strict(Robot, tmp_path / "none.yaml")


def test_a_folder_is_no_file(tmp_path):
    with pytest.raises(FileError, match="directory"):
        load_strict(Robot, tmp_path)


def test_bytes_are_no_text(tmp_path):
    path = tmp_path / "robot.yaml"
    path.write_bytes(b"\xff\xfe\x00speed")
    with pytest.raises(FileError, match="not a text file"):
        load_strict(Robot, path)


SEVERAL = """
Slow: {speed: 0.1}
Fast: {speed: 9}
Plain: {}
"""


def test_one_entry_of_several(load):
    assert load(SEVERAL, child="Fast").speed == 9
    assert load(SEVERAL, child="Plain") == Robot()


def test_an_unknown_entry_gets_a_guess(load):
    with pytest.raises(FileError, match=r"did you mean 'Slow'\?"):
        load(SEVERAL, child="Slwo")


def test_the_other_entries_are_not_judged(load):
    text = "Good: {speed: 1}\nBad: {sped: 1}"
    assert load(text, child="Good").speed == 1


def test_entries_keep_their_order(tmp_path):
    path = tmp_path / "several.yaml"
    path.write_text(SEVERAL)
    assert entries(path) == ["Slow", "Fast", "Plain"]


def test_two_entries_of_one_name(tmp_path):
    path = tmp_path / "several.yaml"
    path.write_text("Slow: {}\nSlow: {speed: 1}")
    with pytest.raises(FieldError, match="appears twice"):
        entries(path)


def test_override_lies_over_the_file(load):
    robot = load("speed: 1\ncount: 5", override="speed: 2")
    assert (robot.speed, robot.count) == (2, 5)


def test_override_reaches_below(load):
    robot = load(
        "support: !Leg {length: 3, joints: 9}",
        override="support: !Leg {length: 4}",
    )
    assert robot.support == Leg(length=4.0, joints=9)


def test_a_bad_override_says_where(load):
    with pytest.raises(FieldError, match="--scenario-text:1: sped"):
        load("{}", override="sped: 2")


def test_defaults_fill_what_is_not_named(load):
    robot = load("speed: 1", defaults=Robot(count=8))
    assert (robot.speed, robot.count) == (1, 8)
