"""Examples of docstrings are examples in the reference, too."""

import pytest

griffe = pytest.importorskip("griffe")

from examples import Examples

SOURCE = '''
def double(x):
    """Doubles a number.

    Example:
        >>> double(2)
        4
    """
    return 2 * x
'''


def test_an_example_becomes_a_section_of_code(tmp_path):
    (tmp_path / "doubling.py").write_text(SOURCE)
    module = griffe.load(
        "doubling",
        search_paths=[tmp_path],
        extensions=griffe.load_extensions(Examples()),
    )
    _, section = module["double"].docstring.parse("google")
    assert section.kind is griffe.DocstringSectionKind.examples
    assert ">>> double(2)" in section.value[0][1]
