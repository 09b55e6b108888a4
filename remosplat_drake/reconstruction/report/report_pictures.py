"""Encodes pictures and plots of a quality report as text in an HTML page."""

import base64
import io
from collections.abc import Sequence

import numpy as np

from remosplat_drake.base.html_report import new_plot, to_svg
from remosplat_drake.signals.coverage import FREE, SURFACE, UNSEEN, Coverage

_MAX_WIDTH = 400  # Width of a picture in the page [pixels].
_DEPTH_ERRORS = (0.01, 0.02, 0.05, 0.1)  # Ends of colour scales [m].
_UNKNOWN = "#c8c8c8"
_STATE_COLORS = {UNSEEN: "#d9534f", FREE: "#eef3f8", SURFACE: "#33475b"}
_STATE_NAMES = {UNSEEN: "never seen", FREE: "free", SURFACE: "surface"}
_SLICES = 8


def color_image(image: np.ndarray) -> str:
    """Shrinks an image (h, w, 3) in [0, 1] and encodes it as a data URI."""
    image = _smaller(np.clip(image, 0, 1))
    return _data_uri((255 * image).round().astype(np.uint8), "jpeg")


def depth_image(depth: np.ndarray, limits) -> str:
    """Encodes a depth image (h, w) [m] as a data URI, grey where it is 0.

    Args:
        depth: The image.
        limits: Depths of the first and the last colour [m].
    """
    low, high = limits
    known = np.where(depth > 0, depth, np.nan)
    return _colored((known - low) / max(high - low, 1e-6), "viridis_r")


def depth_error_limit(errors: Sequence[np.ndarray]) -> float:
    """Chooses the depth error at the ends of the colour scale [m]."""
    error = np.abs(np.concatenate([e[np.isfinite(e)] for e in errors]))
    usual = np.percentile(error, 90) if len(error) else 0.0
    return next((x for x in _DEPTH_ERRORS if x >= usual), _DEPTH_ERRORS[-1])


def depth_error_image(error: np.ndarray, limit: float) -> str:
    """Encodes an image of depth errors as a data URI.

    Blue pixels are too near, and red pixels are too far.

    Args:
        error: The errors, shape (h, w) [m]; NaN where unknown, which is grey.
        limit: Error at the ends of the colour scale [m].
    """
    return _colored(0.5 + error / (2 * limit), "RdBu_r")


def error_histogram(errors: dict[str, np.ndarray]) -> str:
    """Draws a histogram of distance errors [m] by oracle, as SVG."""
    axes, figure = new_plot(7.5, 2.8)
    reach = max(np.percentile(np.abs(e), 99.5) for e in errors.values())
    reach = 1e3 * max(reach, 1e-4)
    bins = np.linspace(-reach, reach, 81)
    for name, error in errors.items():
        axes.hist(
            np.clip(1e3 * error, -reach, reach),
            bins,
            histtype="stepfilled",
            alpha=0.45,
            label=name,
        )
    axes.set_yscale("log")
    axes.set_xlabel("distance error [mm]")
    axes.set_ylabel("points")
    axes.axvline(0, color="#616e7c", lw=0.8)
    axes.legend(frameon=False)
    return to_svg(figure)


def coverage_slices(coverage: Coverage) -> str:
    """Draws horizontal slices of a coverage, the lowest first, as SVG."""
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    heights = coverage.state.shape[2]
    shown = np.unique(np.linspace(0, heights - 1, _SLICES).round().astype(int))
    columns = min(4, len(shown))
    rows = -(-len(shown) // columns)
    lower, upper = coverage.lower, coverage.upper
    width, depth = (upper - lower)[:2]
    row = 0.5 + 2.0 * float(np.clip(depth / width, 0.3, 2))
    figure = Figure(figsize=(9.6, 0.5 + row * rows), layout="constrained")
    grid = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes in grid[len(shown) :]:
        axes.set_axis_off()
    for axes, k in zip(grid, shown.tolist(), strict=False):
        axes.imshow(
            coverage.state[:, :, k].T,
            origin="lower",
            extent=(lower[0], upper[0], lower[1], upper[1]),
            cmap=ListedColormap([_STATE_COLORS[s] for s in range(3)]),
            vmin=0,
            vmax=2,
            interpolation="nearest",
        )
        height = lower[2] + (k + 0.5) * coverage.voxel
        axes.set_title(f"z = {height:.2f} m", fontsize=9)
        axes.tick_params(labelsize=7)
    figure.legend(
        handles=[
            Patch(fc=_STATE_COLORS[s], label=_STATE_NAMES[s], ec="#9aa5b1")
            for s in (FREE, SURFACE, UNSEEN)
        ],
        loc="outside upper left",
        ncols=3,
        frameon=False,
    )
    return to_svg(figure)


def _colored(values: np.ndarray, colors: str) -> str:
    """Colours of values in [0, 1], by a colour map; NaN is unknown."""
    from matplotlib import colormaps

    colormap = colormaps[colors].with_extremes(bad=_UNKNOWN)
    masked = np.ma.masked_invalid(_nearest_smaller(values))
    return _data_uri(colormap(masked, bytes=True)[..., :3], "jpeg")


def _smaller(image: np.ndarray) -> np.ndarray:
    """Image of the means over blocks of pixels, at most `_MAX_WIDTH` wide."""
    block = -(-image.shape[1] // _MAX_WIDTH)
    height, width = (n // block * block for n in image.shape[:2])
    image = image[:height, :width]
    return image.reshape(height // block, block, width // block, block, 3).mean(
        axis=(1, 3)
    )


def _nearest_smaller(image: np.ndarray) -> np.ndarray:
    """Image of one pixel of each block, since depths must not be averaged."""
    block = -(-image.shape[1] // _MAX_WIDTH)
    return image[block // 2 :: block, block // 2 :: block]


def _data_uri(image: np.ndarray, kind: str) -> str:
    from matplotlib.image import imsave

    data = io.BytesIO()
    imsave(data, image, format=kind, pil_kwargs={"quality": 88})
    text = base64.b64encode(data.getvalue()).decode()
    return f"data:image/{kind};base64,{text}"
