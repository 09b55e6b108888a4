"""Results of the noise experiment as a file, as tables and as a picture."""

import dataclasses as dc
import json
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from apps.studies.noise.experiment import Accuracy, NoisyRun
from remosplat_drake.base.atomic_file import atomic_write
from remosplat_drake.base.errors import FileError
from remosplat_drake.base.strict_json import parse_json
from remosplat_drake.reconstruction.report.quality import DistanceQuality

ACCURACY_HEADINGS = (
    "scene",
    "method",
    "spheres",
    "median",
    "99 %",
    "over",
    "under",
)
TRIAL_HEADINGS = (
    "scene",
    "method",
    "success",
    "reached",
    "collided",
    "clearance",
    "at start",
)

ACCURACY_TITLE = (
    "Distance errors [mm]: median and 99 % of their size,"
    " largest over- and under-estimate"
)
TRIAL_TITLE = (
    "Runs: success is reached without contact; least true clearance,"
    " and least distance measured at the start [mm]"
)

STOPPING = 0.021
"""Stopping distance d_s of the controller, to compare errors with [m]."""

_COLORS = ("#2463eb", "#e5484d", "#2f9e62")
_INK, _FAINT = "#1d2430", "#7a8494"


class Results:
    """Measurements so far, by scene and method, kept in a file.

    Every entry is saved at once, so an interrupted experiment can resume.
    Entries contain the revision of the map and the settings of their
    measurement; entries with other settings are ignored.

    Attributes:
        accuracy: Distance errors by scene and method.
        trials: Runs by scene and method, one per start.

    Raises:
        FileError: The file does not hold such results.
    """

    def __init__(self, path: Path):
        self.accuracy: dict[tuple[str, str], Accuracy] = {}
        self.trials: dict[tuple[str, str], list[NoisyRun]] = {}
        self._path = path
        self._kept: dict[str, dict] = {}
        if path.exists():
            try:
                self._kept = dict(parse_json(path.read_text(), path))
            except (OSError, ValueError, TypeError) as error:
                raise FileError(path, "holds no such results") from error

    def kept_accuracy(self, key: str) -> Accuracy | None:
        """Returns the errors kept under a key and equal settings, if any."""
        entry = self._kept.get(key)
        if entry is None:
            return None
        return Accuracy(
            DistanceQuality(**entry["quality"]), tuple(entry["quantiles"])
        )

    def kept_trial(self, key: str) -> NoisyRun | None:
        """Returns the run kept under a key and equal settings, if any."""
        entry = self._kept.get(key)
        return None if entry is None else NoisyRun(**entry)

    def keep(self, key: str, value: Accuracy | NoisyRun) -> None:
        """Adds an entry to the file."""
        self._kept[key] = dc.asdict(value)
        with atomic_write(self._path) as file:
            json.dump(self._kept, file, indent=1)

    def accuracy_rows(self) -> list[tuple[str, ...]]:
        """Rows of the table of errors, in the order of `ACCURACY_HEADINGS`."""
        return [
            (
                *names,
                str(result.quality.count),
                f"{1e3 * result.quality.median:.1f}",
                f"{1e3 * result.quality.percentile_99:.1f}",
                f"{1e3 * result.quality.over:.1f}",
                f"{1e3 * result.quality.under:.1f}",
            )
            for names, result in self.accuracy.items()
        ]

    def trial_rows(self) -> list[tuple[str, ...]]:
        """Rows of the table of runs, in the order of `TRIAL_HEADINGS`."""
        return [
            (
                *names,
                f"{sum(t.success for t in trials)} of {len(trials)}",
                str(sum(t.reached for t in trials)),
                str(sum(t.truth_clearance_min <= 0 for t in trials)),
                _millimetres(min(t.truth_clearance_min for t in trials)),
                _millimetres(min(t.start_clearance for t in trials)),
            )
            for names, trials in self.trials.items()
        ]


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.0f}" if np.isfinite(length) else "beyond"


def markdown(headings: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    """Writes a Markdown table, with numbers aligned to the right."""
    rule = ["---", "---", *["---:"] * (len(headings) - 2)]
    return "".join(
        f"| {' | '.join(cells)} |\n" for cells in (headings, rule, *rows)
    )


def draw(results: Results) -> Figure:
    """Draws errors beside success, a row for each scene and method."""
    pairs = list(results.accuracy)
    scenes = list(dict.fromkeys(scene for scene, _ in pairs))
    methods = list(dict.fromkeys(method for _, method in pairs))
    rows = len(scenes) * (len(methods) + 1)
    figure = Figure(figsize=(13, 1.6 + 0.32 * rows))
    figure.set_layout_engine("constrained", w_pad=0.15, h_pad=0.1)
    figure.suptitle(
        "Distance methods and floaters", size=16, weight="bold", color=_INK
    )
    errors, success = figure.subplots(1, 2, sharey=True, width_ratios=(2.6, 1))
    ticks = []
    for i, scene in enumerate(scenes):
        ticks.append(i * (len(methods) + 1) + (len(methods) - 1) / 2)
        for j, method in enumerate(methods):
            if (scene, method) not in results.accuracy:
                continue
            y = i * (len(methods) + 1) + j
            color = _COLORS[j % len(_COLORS)]
            label = method if i == 0 else None
            _draw_errors(
                errors, y, results.accuracy[scene, method], color, label
            )
            _draw_success(
                success, y, results.trials.get((scene, method), []), color
            )
    errors.set_yticks(ticks, scenes, size=11)
    errors.invert_yaxis()
    _dress(errors, success)
    figure.legend(
        *errors.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=len(methods),
        frameon=False,
        fontsize=11,
    )
    return figure


def _draw_errors(
    axes: Axes, y: float, result: Accuracy, color: str, label: str | None
):
    least, low, middle, high, most = 1e3 * np.array(result.quantiles)
    axes.plot([least, most], [y, y], color=color, lw=1.2)
    axes.plot(
        [low, high],
        [y, y],
        color=color,
        lw=7,
        solid_capstyle="butt",
        label=label,
    )
    axes.plot(middle, y, "o", color="white", mec=_INK, ms=5)


def _draw_success(axes: Axes, y: float, trials: list[NoisyRun], color: str):
    if not trials:
        return
    share = np.mean([t.success for t in trials])
    axes.barh(y, share, 0.6, color=color)
    axes.text(
        share + 0.02,
        y,
        f"{sum(t.success for t in trials)} of {len(trials)}",
        va="center",
        size=10,
        color=_INK,
    )


def _dress(errors: Axes, success: Axes):
    errors.set_title(
        "Measured minus true distance [mm]\ndot: median, bar: 98 %, line: all",
        size=11,
        color=_INK,
    )
    errors.set_xscale("symlog", linthresh=10, linscale=1.5)
    ticks = (-500, -100, -10, -5, 0, 5, 10, 100, 500)
    errors.set_xticks(ticks, [f"{x}".replace("-", "−") for x in ticks])
    errors.set_xlim(-600, 600)
    errors.axvline(0, color=_FAINT, lw=0.8, zorder=0)
    errors.axvline(1e3 * STOPPING, color=_FAINT, ls="--", lw=1, zorder=0)
    errors.annotate(
        " stopping distance",
        (1e3 * STOPPING, 0),
        xycoords=("data", "axes fraction"),
        xytext=(2, 4),
        textcoords="offset points",
        size=9,
        color=_FAINT,
    )
    success.set_title("Reached without touching anything", size=11, color=_INK)
    success.set_xlim(0, 1.25)
    success.set_xticks([0, 0.5, 1], ["0", "50 %", "100 %"])
    for axes in (errors, success):
        axes.spines[["top", "right", "left"]].set_visible(False)
        axes.tick_params(axis="y", length=0)
