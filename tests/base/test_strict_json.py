"""JSON of others: bounded, or refused in one line."""

import math

import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.strict_json import (
    MAX_DEPTH,
    as_number,
    as_whole_number,
    parse_json,
    parse_json_object,
    read_json_object,
)


def nested(levels: int) -> str:
    return "[" * levels + "]" * levels


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "not JSON"),
        ("{", "not JSON"),
        (b"\xff\xfe\xfd", "not JSON"),
        ('{"a": 1, "b": 2, "a": 3}', "the key 'a' appears twice"),
        (nested(MAX_DEPTH + 1), "nested more than 32 levels deep"),
        (nested(900), "nested more than 32 levels deep"),
        ("[" * 10**6, "nested more than 32 levels deep"),
        ('{"a":' * 10**5, "nested more than 32 levels deep"),
    ],
)
def test_what_is_refused(text, problem):
    with pytest.raises(FileError, match=rf"a\.json: .*{problem}") as caught:
        parse_json(text, "a.json")
    assert "\n" not in str(caught.value)


def test_what_is_read():
    assert parse_json(nested(MAX_DEPTH), "a.json")
    assert parse_json('{"a": [1, 2.5, null, true, "x"]}', "a.json") == {
        "a": [1, 2.5, None, True, "x"]
    }
    assert parse_json(b'"\xc3\xa9"', "a.json") == "é"
    assert math.isnan(parse_json("NaN", "a.json"))


def test_whole_numbers_fit_an_array_or_are_floats():
    for whole in (0, 2**63 - 1, -(2**63)):
        value = parse_json(str(whole), "a.json")
        assert isinstance(value, int) and value == whole
    for text in (str(2**63), str(-(2**63) - 1), "-" + "1" * 30):
        value = parse_json(text, "a.json")
        assert isinstance(value, float)
        assert value == float(text)
    assert parse_json("1" * 5000, "a.json") == math.inf


def test_only_objects_where_one_is_expected():
    assert parse_json_object("{}", "a.json") == {}
    with pytest.raises(FileError, match="expected a JSON object"):
        parse_json_object("[]", "a.json")


def test_files_are_read_or_named(tmp_path):
    path = tmp_path / "a.json"
    with pytest.raises(FileError, match=r"a\.json: No such file"):
        read_json_object(path)
    path.write_text('{"a": "é"}', encoding="utf-8")
    assert read_json_object(path) == {"a": "é"}


@pytest.mark.parametrize(
    "value", [True, None, "1", [], math.nan, math.inf, [[0] * 10**4] * 10]
)
def test_what_is_no_number(value):
    with pytest.raises(FieldError, match="a: b: expected a number") as caught:
        as_number("a", "b", value)
    assert len(str(caught.value)) < 200


def test_whole_numbers_have_bounds():
    assert as_whole_number("a", "b", 3, 1, 3) == 3
    for value in (0, 4, 2.0, True, "2"):
        with pytest.raises(FieldError, match="whole number from 1 to 3"):
            as_whole_number("a", "b", value, 1, 3)
