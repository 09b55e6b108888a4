"""Measures the registration of colour to depth from their edges.

At the outline of a surface, the depth changes, and often the colour, too. So
the edges of correctly registered images match best without a shift.
"""

import dataclasses as dc

import numpy as np

from remosplat_drake.capture.capture import Capture

_MAX_FRAMES, _FEW_FRAMES, _COARSE = 24, 12, 320
"""An unknown shift is searched for in at most this many views (first number).
The correlation at a given shift is computed from at most this many views
(second number), whose images are reduced to about this width (third number)
[pixels].
"""
_MIN_JUMP = 0.05
"""There is an edge between neighbouring pixels if the relative difference of
their depths exceeds this.
"""

_MIN_EDGES = 0.0005
"""An image is usable if at least this fraction of its pixels is at an edge."""

_MIN_FRAMES = 5
"""At least this many images must be usable; in fewer images, edges may match by
chance."""

_MIN_CORRELATION = 0.1
"""Edges are unrelated if their correlation is below this at all shifts."""

_MAX_SHIFT = 0.08
"""Shifts up to this fraction of the image's width are tried."""

_TOLERANCE, _MIN_TOLERANCE = 0.01, 4.0
"""A shift up to this size is not significant: the first number is a fraction of
the image's width, the second number a lower limit of the size [pixels].
"""

_MUCH_WORSE = 0.8
"""Colours are shifted if their correlation without a shift is below this
multiple of the best correlation."""

_WIDTH = 2.0
"""Standard deviation of the blur that is applied to edges, so that edges that
are slightly displaced still match [pixels].
"""


@dc.dataclass(frozen=True)
class Registration:
    """The shift at which the edges of colour and depth match best.

    Attributes:
        shift: Columns and rows by which the colour image has to be moved to
            lie on the depth image [pixels].
        correlation: Correlation of the edges at that shift.
        unshifted: Correlation of the edges without a shift.
        tolerance: Length up to which a shift is not significant [pixels].
    """

    shift: tuple[int, int]
    correlation: float
    unshifted: float
    tolerance: float

    @property
    def is_off(self) -> bool:
        """Whether colours and depths clearly do not match."""
        return (
            float(np.hypot(*self.shift)) > self.tolerance
            and self.unshifted < _MUCH_WORSE * self.correlation
        )


def measure_registration(capture: Capture) -> Registration | None:
    """Finds the shift of colours at which their edges match those of depths.

    Args:
        capture: The views; at most two dozen of them are used.

    Returns:
        The shift; None if too few edges match to determine it.
    """
    width = capture.size[1]
    reach = max(2, round(_MAX_SHIFT * width))
    found = _edge_correlations(capture, reach)
    if len(found) < _MIN_FRAMES:
        return None
    total = np.mean(found, axis=0)
    if total.max() < _MIN_CORRELATION:
        return None
    row, column = np.unravel_index(total.argmax(), total.shape)
    return Registration(
        shift=(int(column) - reach, int(row) - reach),
        correlation=float(total.max()),
        unshifted=float(total[reach, reach]),
        tolerance=max(_MIN_TOLERANCE, _TOLERANCE * width),
    )


def edge_correlation(capture: Capture, step: int = 0) -> float:
    """Computes the correlation of the edges of depths and colours.

    Args:
        capture: The views; at most a dozen are used.
        step: Offset of frames: depths of frame i are compared with the colours
            of frame i + step.

    Returns:
        The mean correlation; 0 if there are too few edges.
    """
    n = len(capture) - abs(step)
    stride = max(1, capture.size[1] // _COARSE)
    found = []
    for i in _spread(n, _FEW_FRAMES):
        view = i + max(0, -step)
        depth = capture.depth[view, ::stride, ::stride]
        rgb = capture.rgb[view + step, ::stride, ::stride]
        jumps = depth_edges(depth)
        if jumps.mean() >= _MIN_EDGES:
            found.append(_correlations(color_edges(rgb), jumps, 0))
    return float(np.mean(found)) if len(found) >= _MIN_FRAMES else 0.0


def _edge_correlations(capture: Capture, reach: int) -> list[np.ndarray]:
    """Mean correlation of the edges of some views, for all shifts."""
    found = []
    for view in _spread(len(capture), _MAX_FRAMES):
        jumps = depth_edges(capture.depth[view])
        if jumps.mean() < _MIN_EDGES:
            continue
        edges = color_edges(capture.rgb[view])
        if capture.hidden is not None:
            edges[capture.hidden[view]] = 0
        found.append(_correlations(edges, jumps, reach))
    return found


def _spread(n: int, most: int) -> np.ndarray:
    """Indices of up to `most` of n views, evenly spread."""
    if n < 1:
        return np.zeros(0, int)
    return np.unique(np.linspace(0, n - 1, most).round().astype(int))


def color_edges(rgb: np.ndarray) -> np.ndarray:
    """Computes the brightness gradient's magnitude, (h, w, 3) to (h, w)."""
    down, right = np.gradient(rgb.astype(float).mean(axis=-1))
    return np.hypot(down, right)


def depth_edges(depth: np.ndarray) -> np.ndarray:
    """Marks pixels at a surface's outline with 1, others with 0, shape (h, w).

    If the depths of two neighbouring pixels differ, only the pixel of the
    nearer surface is marked, since the outline belongs to this surface.
    """
    edges = np.zeros(depth.shape)
    for axis in (0, 1):
        rows, marks = np.moveaxis(depth, axis, 0), np.moveaxis(edges, axis, 0)
        here, there = rows[:-1], rows[1:]
        known = (here > 0) & (there > 0)
        marks[:-1][known & (there - here > _MIN_JUMP * here)] = 1
        marks[1:][known & (here - there > _MIN_JUMP * there)] = 1
    return edges


def _correlations(a: np.ndarray, b: np.ndarray, reach: int) -> np.ndarray:
    """Correlation of b with a, moved by -reach .. reach rows and columns."""
    a, b = _blur_spectrum(a), _blur_spectrum(b)
    norm = np.sqrt((np.abs(a) ** 2).sum() * (np.abs(b) ** 2).sum())
    product = np.fft.ifft2(b * a.conj()).real * a.size / max(norm, 1e-30)
    shifts = np.arange(-reach, reach + 1)
    return product[np.ix_(shifts, shifts)]


def _blur_spectrum(image: np.ndarray) -> np.ndarray:
    """The spectrum of an image without its mean, blurred."""
    height, width = image.shape
    frequency = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width))
    blur = np.exp(-2 * (np.pi * _WIDTH * frequency) ** 2)
    return np.fft.fft2(image - image.mean()) * blur
