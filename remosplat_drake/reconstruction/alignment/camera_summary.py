"""Sentences of a report about the errors that all images of a camera share."""

from typing import NamedTuple

import numpy as np

from remosplat_drake.reconstruction.alignment.alignment import Alignment
from remosplat_drake.reconstruction.alignment.alignment_summary import (
    CameraError,
    digits,
    doubt,
)
from remosplat_drake.reconstruction.alignment.camera_errors import (
    ASPECT,
    CENTER_X,
    CENTER_Y,
    COUNT,
    DELAY,
    FOCAL,
    GROWTH,
    K1,
    K2,
    OFFSET,
    READOUT,
    SCALE,
    SHIFT,
    TURN,
)


class _Kind(NamedTuple):
    """Texts and units with which an error is reported.

    Attributes:
        name: Name of the error.
        factor: Factor to display units.
        unit: That unit; empty for a plain number.
        words: A sentence with placeholders for the error's size and direction.
            It is empty if `_words_together` reports the error.
        directions: Meanings of a positive and of a negative error.
    """

    name: str
    factor: float
    unit: str
    words: str = ""
    directions: tuple[str, str] = ("", "")


_LONG = "longer", "shorter"
_DEG = 180 / np.pi

_KINDS = {
    SCALE: _Kind(
        "depth scale", 100, "%",
        "Depths are {size} {way} than the capture says ({doubt}).", _LONG,
    ),
    OFFSET: _Kind(
        "depth offset", 1e3, "mm",
        "Depths are {size} {way} than the capture says, near and far"
        " ({doubt}).", _LONG,
    ),
    GROWTH: _Kind(
        "growth of depths with their square", 100, "% per m",
        "Depths are {way} than the capture says by {size}"
        " ({doubt}).", _LONG,
    ),
    FOCAL: _Kind(
        "focal length", 100, "%",
        "The focal length is {size} {way} than the capture says ({doubt}).",
        _LONG,
    ),
    ASPECT: _Kind(
        "vertical relative to horizontal focal length", 100, "%",
        "Relative to the horizontal, the vertical focal length is {size} {way}"
        " than the capture says ({doubt}).", _LONG,
    ),
    CENTER_X: _Kind(
        "principal point to the right", 1, "px",
        "The principal point is {size} farther {way} than the capture says"
        " ({doubt}).", ("right", "left"),
    ),
    CENTER_Y: _Kind(
        "principal point downwards", 1, "px",
        "The principal point is {size} farther {way} than the capture says"
        " ({doubt}).", ("down", "up"),
    ),
    K1: _Kind(
        "radial distortion k1", 1, "",
        "Images have a radial distortion k1 of {way}{size} that the capture"
        " does not contain ({doubt}).", ("+", "-"),
    ),
    K2: _Kind(
        "radial distortion k2", 1, "",
        "Images have a radial distortion k2 of {way}{size} that the capture"
        " does not contain ({doubt}).", ("+", "-"),
    ),
    DELAY: _Kind(
        "time from a pose to its image", 1e3, "ms",
        "Images are {size} {way} than their poses ({doubt}).",
        ("newer", "older"),
    ),
    READOUT: _Kind(
        "read-out from top to bottom", 1e3, "ms",
        "Images are read out in {size}, from {way} ({doubt}).",
        ("top to bottom", "bottom to top"),
    ),
    **{
        TURN + i: _Kind(f"turn on the mount about {axis}", _DEG, "degrees")
        for i, axis in enumerate("xyz")
    },
    **{
        SHIFT + i: _Kind(f"shift on the mount along {axis}", 1e3, "mm")
        for i, axis in enumerate("xyz")
    },
}  # fmt: skip
"""Texts and units of each error, in the order of reports."""


def camera_errors(alignment: Alignment) -> list[CameraError]:
    """Lists the errors that all images of a capture share."""
    factors = _factors(alignment)
    # A corrected error is reported as it was corrected.
    found = alignment.undone + alignment.error[-COUNT:]
    values = np.where(alignment.undone != 0, alignment.undone, found)
    return [
        CameraError(
            name=kind.name,
            value=float(factors[k] * values[k]),
            deviation=float(factors[k] * alignment.deviations[k]),
            unit=kind.unit,
            undone=bool(alignment.undone[k]),
        )
        for k, kind in _KINDS.items()
    ]


def words_of_camera(alignment: Alignment) -> list[str]:
    """Describes each corrected error of a capture in a sentence."""
    sentences = [
        kind.words.format(
            size=_size(abs(error.value), error.deviation, error.unit),
            way=kind.directions[int(error.value < 0)],
            doubt=doubt(error.deviation, error.unit),
        )
        for kind, error in zip(
            _KINDS.values(), camera_errors(alignment), strict=True
        )
        if kind.words and error.undone
    ]
    mount = [
        _length_of(alignment, first)
        for first in (TURN, SHIFT)
        if alignment.undone[first : first + 3].any()
    ]
    if mount:
        sizes, doubts = zip(*mount, strict=True)
        sentences.append(
            f"The camera is {' and '.join(sizes)} from its configured pose"
            f" ({', '.join(doubts)})."
        )
    return sentences


def _length_of(alignment: Alignment, first: int) -> tuple[str, str]:
    """Formats the length of three errors together, and its deviation."""
    kind, three = _KINDS[first], slice(first, first + 3)
    vector = alignment.undone[three]
    size = float(np.linalg.norm(vector))
    along = vector / size
    C = alignment.covariance[-COUNT:, -COUNT:][three, three]
    deviation = float(kind.factor * np.sqrt(along @ C @ along))
    return (
        _size(kind.factor * size, deviation, kind.unit),
        doubt(deviation, kind.unit),
    )


def _factors(alignment: Alignment) -> np.ndarray:
    """Factors that convert errors to the display units of `_KINDS`, (k,)."""
    factors = np.array([_KINDS[k].factor for k in range(COUNT)], float)
    # A principal point is a part of the capture's own focal length.
    focal = np.median(alignment.capture.K[:, [0, 1], [0, 1]], axis=0)
    factors[CENTER_X] *= focal[0] / (1 + alignment.undone[FOCAL])
    factors[CENTER_Y] *= focal[1] / (
        1 + alignment.undone[[FOCAL, ASPECT]].sum()
    )
    return factors


def _size(value: float, deviation: float, unit: str) -> str:
    """Formats a size with its significant decimals."""
    return f"{value:.{digits(deviation)}f} {unit}".rstrip()
