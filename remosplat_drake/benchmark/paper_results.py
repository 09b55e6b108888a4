"""The results of the paper, which tables show beside this package's results."""

import dataclasses as dc

PAPER_TRIALS = 1000
"""Number of scenes in the paper's synthetic benchmark."""


@dc.dataclass(frozen=True)
class PaperRow:
    """One row of the paper's Table I.

    Attributes:
        label: Name of the method in the paper's table.
        successes: Number of successful trials out of `PAPER_TRIALS`.
        average_distance: Mean clearance over the trials that all methods of the
            paper's table solve (marked by a star in that table) [m].
        gracefulness: Mean acceleration of the end effector over these trials
            [m/s^2].
        path_length: Path length of the end effector over these trials [m].
        collisions: Number of trials with a collision out of `PAPER_TRIALS`.
        solve: Mean and standard deviation of the solver's time [ms].
        rate: Control rate [Hz]; None if the paper does not state it.
    """

    label: str
    successes: int
    average_distance: float
    gracefulness: float
    path_length: float
    collisions: int
    solve: tuple[float, float]
    rate: float | None = None


PAPER_TABLE_I = {
    "sdf-hard": PaperRow(
        "RMMI, ground truth, hard", 778, 0.087, 0.388, 0.724, 0, (0.15, 0.04)
    ),
    "sdf-active": PaperRow(
        "RMMI, ground truth, active", 846, 0.112, 0.279, 0.759, 0, (0.15, 0.04)
    ),
    "ellipsoid-hard": PaperRow(
        "sphere-to-ellipsoid, hard",
        776,
        0.087,
        0.434,
        0.723,
        0,
        (0.17, 0.08),
        17.2,
    ),
    "ellipsoid-active": PaperRow(
        "sphere-to-ellipsoid, active",
        856,
        0.113,
        0.291,
        0.762,
        0,
        (0.17, 0.03),
        17.2,
    ),
    "depth-hard": PaperRow(
        "depth rasterisation, hard",
        800,
        0.086,
        0.411,
        0.726,
        0,
        (0.21, 0.06),
        24.2,
    ),
    "depth-active": PaperRow(
        "depth rasterisation, active",
        845,
        0.107,
        0.272,
        0.754,
        0,
        (0.20, 0.06),
        24.2,
    ),
}
"""The rows of the paper's Table I, keyed by the name of the corresponding
method of this package."""

SCAN, NOISY_SCAN = "scan", "noisy scan"
"""Names of the families of cases that repeat the paper's experiments 2 and
3."""


@dc.dataclass(frozen=True)
class PaperScanRow:
    """One row of the paper's Table II or III.

    Attributes:
        label: Name of the method in the paper's table.
        successes: Number of targets reached out of `PAPER_TARGETS`.
        gracefulness: Mean acceleration over the successful trials [m/s^2]; None
            if there are none.
        collisions: Number of trials with a collision out of `PAPER_TARGETS`;
            None if the paper does not state it.
    """

    label: str
    successes: int
    gracefulness: float | None
    collisions: int | None


PAPER_TARGETS = 7
"""Number of targets in the paper's scanned scene. One of these targets is out
of reach for all methods."""

PAPER_SCANS = {
    SCAN: (
        PaperScanRow("sphere-to-ellipsoid", 6, 0.148, 0),
        PaperScanRow("depth rasterisation", 6, 0.196, 0),
    ),
    NOISY_SCAN: (
        PaperScanRow("sphere-to-ellipsoid", 0, None, None),
        PaperScanRow("depth rasterisation", 4, 0.281, 0),
    ),
}
"""The rows of the paper's Tables II and III, keyed by the family of the
corresponding cases."""
