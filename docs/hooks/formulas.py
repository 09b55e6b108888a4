"""Conversion of formulas to MathML during the build, without any script."""

import html
import importlib.util
import re
from pathlib import Path

from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

FONT = "assets/STIXTwoMath-Regular.ttf"
"""A font with tables for mathematics, which few systems contain."""

_BETTER = (
    # Without this attribute, a dot is drawn far above its letter.
    (r"<mover>(?=.{,99}?</mi>(</mrow>)?<mo)", '<mover accent="true">'),
    # latex2mathml marks these names as operators, which adds spaces.
    (r"<mo>(min|max|det)</mo>", r"<mi>\1</mi>"),
    # Browsers add spaces around bars, as around operators.
    (r'(?<=stretchy="false")>(?=&#x0007C;)', ' lspace="0" rspace="0">'),
)
"""Patterns in the output of latex2mathml, with their replacements."""

_FORMULA = re.compile(
    r'<(span|div) class="arithmatex">\\[(\[](.*?)\\[)\]]</\1>', re.S
)


def with_mathml(page: str) -> str:
    """Returns a page's HTML with all formulas converted from LaTeX to MathML.

    The extension `arithmatex` marks the formulas.
    """
    return _FORMULA.sub(_as_mathml, page)


def _as_mathml(match: re.Match[str]) -> str:
    tag, latex = match.groups()
    display = "block" if tag == "div" else "inline"
    mathml = convert(html.unescape(latex), display=display)
    if "\\" in mathml or "<mi>&</mi>" in mathml:
        raise PluginError(f"latex2mathml cannot convert {latex!r}")
    for pattern, better in _BETTER:
        mathml = re.sub(pattern, better, mathml)
    return mathml


def on_page_content(content: str, **_) -> str:
    """Converts the formulas of a page; MkDocs calls this for every page."""
    return with_mathml(content)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the font of the formulas to the files of the site."""
    package = importlib.util.find_spec("ziamath")
    assert package is not None and package.origin is not None
    font = Path(package.origin).parent / "fonts" / Path(FONT).name
    files.append(File.generated(config, FONT, abs_src_path=str(font)))
    return files
