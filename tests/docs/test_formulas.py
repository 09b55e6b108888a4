"""Formulas of the documentation become MathML, or the build fails."""

import pytest

pytest.importorskip("mkdocs")
pytest.importorskip("latex2mathml")

from formulas import with_mathml
from mkdocs.exceptions import PluginError


def span(latex: str) -> str:
    return f'so <span class="arithmatex">\\({latex}\\)</span> holds'


def test_inline_and_displayed_formulas_are_converted():
    page = with_mathml(
        span("d_j &lt; 1") + '<div class="arithmatex">\\[\na = b\n\\]</div>'
    )
    assert page.count("<math ") == 2
    assert "arithmatex" not in page
    assert 'display="inline"' in page and 'display="block"' in page
    assert "<mo>&#x0003C;</mo>" in page


def test_dots_and_bars_sit_on_their_letters():
    assert '<mover accent="true">' in with_mathml(span(r"\dot q"))
    assert '<mover accent="true">' in with_mathml(span(r"\bar{q}"))


def test_bars_are_as_tall_as_their_letters():
    page = with_mathml(span(r"a^\top \bar u + r^\top |a|"))
    bar = '<mo stretchy="false" lspace="0" rspace="0">&#x0007C;</mo>'
    assert page.count(bar) == 2


def test_what_is_not_known_ends_the_build():
    with pytest.raises(PluginError, match="cannot convert"):
        with_mathml(span(r"\begin{aligned} a &amp;= b \end{aligned}"))
