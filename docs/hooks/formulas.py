"""Formulas as MathML, made while the pages are built: no script draws them."""

import html
import importlib.util
import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

FONT = "assets/STIXTwoMath-Regular.ttf"
"""A font with the tables that formulas need; few systems have one."""

_BETTER = (
    # Without the mark a dot hovers far above its letter.
    (r"<mover>(?=.{,99}?</mi>(</mrow>)?<mo)", '<mover accent="true">'),
    # These are operators only by their tag.
    (r"<mo>(min|max|det)</mo>", r"<mi>\1</mi>"),
    # Bars are spaced as operators, too; they stay as tall as their letters.
    (r'(?<=stretchy="false")>(?=&#x0007C;)', ' lspace="0" rspace="0">'),
)
"""What latex2mathml writes, and what looks better."""

_FORMULA = re.compile(
    r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.S
)


def with_mathml(page: str) -> str:
    """A page's HTML, the LaTeX that `arithmatex` has marked as MathML."""
    return _FORMULA.sub(_as_mathml, page)


def _as_mathml(match: re.Match[str]) -> str:
    tag, latex = match.groups()
    display = "block" if tag == "div" else "inline"
    mathml = convert(html.unescape(latex), display=display)
    if "\\" in mathml or "<mi>&</mi>" in mathml:
        raise PluginError(f"latex2mathml does not know all of {latex!r}")
    for pattern, better in _BETTER:
        mathml = re.sub(pattern, better, mathml)
    return mathml


def on_page_content(content: str, **_) -> str:
    """Mkdocs asks for every page."""
    return with_mathml(content)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Mkdocs asks once: the font comes along."""
    package = importlib.util.find_spec("ziamath")
    assert package is not None and package.origin is not None
    font = Path(package.origin).parent / "fonts" / Path(FONT).name
    files.append(File.generated(config, FONT, abs_src_path=str(font)))
    return files
