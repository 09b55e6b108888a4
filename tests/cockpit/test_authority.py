"""Rights of the operator and of other clients."""

import pytest

from remosplat_drake.cockpit.authority import (
    MOST_TRIES,
    Authority,
    is_whole,
    new_code,
)

ANNA, BERT, CARL = range(3)


def test_the_client_that_types_the_code_operates():
    authority = Authority()
    code = authority.code
    assert not authority.operates(ANNA)
    assert authority.admit(ANNA, code) == ""
    assert authority.operates(ANNA) and not authority.operates(BERT)


@pytest.mark.parametrize("change", [str.lower, lambda c: c.replace("-", " ")])
def test_people_type_as_people_do(change):
    authority = Authority()
    assert authority.admit(ANNA, change(authority.code)) == ""


def test_a_code_works_once():
    authority = Authority()
    code = authority.code
    authority.admit(ANNA, code)
    assert "another browser operates" in authority.admit(BERT, code)
    assert authority.leave(ANNA)
    assert authority.code not in ("", code)
    assert "not the code" in authority.admit(BERT, code)
    assert authority.admit(BERT, authority.code) == ""


def test_an_empty_code_never_works():
    authority = Authority()
    authority.admit(ANNA, authority.code)
    assert authority.code == ""
    assert authority.admit(BERT, "")
    assert not authority.operates(BERT)


def test_only_the_operator_hands_over():
    authority = Authority()
    authority.admit(ANNA, authority.code)
    assert not authority.leave(BERT)
    assert authority.operates(ANNA)


def test_who_guesses_is_not_listened_to_any_more():
    authority = Authority()
    for _ in range(MOST_TRIES):
        assert "not the code" in authority.admit(ANNA, "AAAA-AAAA")
    assert "load the page again" in authority.admit(ANNA, authority.code)
    # Others are: no client can lock the operator out.
    assert authority.admit(BERT, authority.code) == ""


def test_codes_differ_and_are_whole():
    codes = {new_code() for _ in range(200)}
    assert len(codes) == 200
    assert all(map(is_whole, codes))
    assert not is_whole(new_code()[:-1])


def test_letters_of_other_scripts_are_wrong_codes():
    assert "not the code" in Authority().admit(CARL, "öäüßÄÖÜẞ")
