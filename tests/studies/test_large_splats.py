"""The study of large splats, with small ones."""

import pytest

from apps.studies import large_splats


@pytest.mark.slow
def test_a_small_hall_is_measured(capsys, tmp_path):
    arguments = ["--millions", "0.05", "--folder", str(tmp_path)]
    assert large_splats.main(arguments) == 0
    printed = capsys.readouterr().out
    assert "0.05" in printed and "first tick" in printed
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--millions", "0"], "--millions: must lie in"),
        (["--millions", "nan"], "--millions: must lie in"),
    ],
)
def test_bad_flags_are_named(arguments, problem, capsys):
    assert large_splats.main(arguments) == 2
    assert problem in capsys.readouterr().err
