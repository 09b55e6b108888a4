"""A sheet of pictures, one per scene, in rows below their family's name."""

import dataclasses as dc
from collections.abc import Sequence

from PIL import Image, ImageDraw, ImageFont

LEGEND = (
    "The robot stands at its start. The target's frame is drawn over"
    " everything: x red, y green, z (approach) blue."
)

_MARGIN, _GAP, _HEADING, _LABEL, _FOOTER = 32, 14, 56, 26, 40
"""Lengths of the sheet's layout [pixels]."""

_PAGE, _INK, _FAINT = (255, 255, 255), (28, 32, 38), (110, 116, 124)
_CORNER = 8
"""Radius of the pictures' corners [pixels]."""


@dc.dataclass(frozen=True)
class Section:
    """Pictures that belong together.

    Attributes:
        title: Heading above the pictures.
        note: Text beside the heading, in a fainter colour.
        names: Captions, one below each picture.
        pictures: Pictures, all of one size.
    """

    title: str
    note: str
    names: Sequence[str]
    pictures: Sequence[Image.Image]


def contact_sheet(sections: Sequence[Section], columns: int) -> Image.Image:
    """Lays the pictures of all sections out on one page.

    Args:
        sections: Sections from top to bottom, with at least one picture in
            all.
        columns: Number of pictures in a row.
    """
    width, height = sections[0].pictures[0].size
    rows = [-(-len(section.pictures) // columns) for section in sections]
    pitch = height + _LABEL + _GAP
    page = Image.new(
        "RGB",
        (
            2 * _MARGIN + columns * (width + _GAP) - _GAP,
            _MARGIN + sum(_HEADING + n * pitch for n in rows) + _FOOTER,
        ),
        _PAGE,
    )
    canvas = ImageDraw.Draw(page)
    y = _MARGIN
    for section, n in zip(sections, rows, strict=True):
        _write_heading(canvas, y, section)
        y += _HEADING
        for i, picture in enumerate(section.pictures):
            corner = (
                _MARGIN + i % columns * (width + _GAP),
                y + i // columns * pitch,
            )
            page.paste(picture, corner, _rounded(picture.size))
            canvas.text(
                (corner[0] + width / 2, corner[1] + height + 5),
                section.names[i],
                font=ImageFont.load_default(14),
                fill=_FAINT,
                anchor="ma",
            )
        y += n * pitch
    canvas.text(
        (_MARGIN, y), LEGEND, font=ImageFont.load_default(14), fill=_FAINT
    )
    return page


def _write_heading(canvas: ImageDraw.ImageDraw, y: int, section: Section):
    font = ImageFont.load_default(26)
    baseline = y + 30
    canvas.text(
        (_MARGIN, baseline), section.title, font=font, fill=_INK, anchor="ls"
    )
    canvas.text(
        (_MARGIN + font.getlength(section.title) + 14, baseline),
        section.note,
        font=ImageFont.load_default(15),
        fill=_FAINT,
        anchor="ls",
    )


def _rounded(size: tuple[int, int]) -> Image.Image:
    """Returns a mask that cuts off the corners smoothly."""
    large = Image.new("L", (4 * size[0], 4 * size[1]), 0)
    ImageDraw.Draw(large).rounded_rectangle(
        (0, 0, 4 * size[0] - 1, 4 * size[1] - 1), 4 * _CORNER, fill=255
    )
    return large.resize(size, Image.Resampling.BOX)
