"""Fields of JSON are only given out if they are what was asked for."""

import json

import pytest

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.json_fields import parse_fields


def fields(**values):
    return parse_fields(json.dumps(values), "file.json")


def test_fields_of_the_right_type_come_back():
    dut = fields(a="x", b=True, c=1, d=[1, 2.5], e=["y"], f={"g": [{}]}, h=None)
    assert (dut.text("a"), dut.flag("b"), dut.whole("c")) == ("x", True, 1)
    assert (dut.number("c"), dut.numbers("d", 2)) == (1, [1, 2.5])
    assert dut.texts("e") == ("y",)
    assert len(dut.inner("f").inners("g")) == 1
    assert dut.has("a") and not dut.has("h") and not dut.has("i")


@pytest.mark.parametrize(
    ("ask", "value", "problem"),
    [
        ("text", 1, "expected text, got 1"),
        ("text", "\ud800", r"expected text, got '\\ud800'"),
        ("flag", 1, "expected true or false, got 1"),
        ("number", True, "expected a finite number, got True"),
        ("number", float("nan"), "expected a finite number, got nan"),
        ("number", 10**400, "expected a finite number, got inf"),
        ("whole", 1.0, "expected a whole number, got 1.0"),
        ("whole", -1, r"must lie in \[0, 9007199254740992\], got -1"),
        ("numbers", "12", "expected a list, got '12'"),
        ("inner", [], "expected an object, got a list"),
        ("inners", [1], "expected an object, got 1"),
        ("text", "x" * 99 + "\n", None),
    ],
)
def test_others_are_refused_by_their_names(ask, value, problem):
    dut = fields(outer={"field": value}).inner("outer")
    if problem is None:
        assert getattr(dut, ask)("field") == value
        return
    with pytest.raises(FieldError, match=f"file.json: outer.field.*{problem}"):
        getattr(dut, ask)("field")


@pytest.mark.parametrize("text", ["", "{", "[" * 10**5, b"\xff"])
def test_what_is_no_json_is_refused_in_one_line(text):
    with pytest.raises(FileError, match=r"file\.json: not JSON") as error:
        parse_fields(text, "file.json")
    assert "\n" not in str(error.value)


def test_a_name_that_cannot_be_printed_is_escaped():
    with pytest.raises(FieldError) as error:
        fields(**{"a\nb": 1}).text("a\nb")
    assert "\n" not in str(error.value)
