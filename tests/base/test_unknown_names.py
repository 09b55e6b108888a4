"""Errors about names that do not exist."""

from remosplat_drake.base.errors import unknown_name


def test_few_names_are_all_listed():
    assert unknown_name("robot", "franky", ["panda", "frankie"]) == (
        "unknown robot 'franky' (did you mean 'frankie'?);"
        " valid: frankie, panda"
    )


def test_of_many_names_the_closest_are_listed():
    names = ["TableReach", "TableTour", *(f"Shelf{k}" for k in range(20))]
    text = unknown_name("scenario", "TabelReach", names)
    assert text.startswith(
        "unknown scenario 'TabelReach' (did you mean 'TableReach'?);"
        " valid: TableReach, TableTour, "
    )
    assert text.endswith(" and 17 others") and len(text) < 160


def test_a_name_like_no_other_has_no_guess():
    text = unknown_name("scenario", "?", [f"Shelf{k}" for k in range(20)])
    assert text.startswith("unknown scenario '?'; valid: ")
