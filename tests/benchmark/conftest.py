"""Scenes and results that the benchmark's tests share."""

from collections.abc import Callable

import pytest

from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.result import (
    SUCCESS,
    Judgement,
    TrialResult,
    WallTimes,
)
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.trial import Trial


@pytest.fixture
def trials() -> list[Trial]:
    """Two scenes, the fastest method, a few ticks each."""
    (method,) = load_methods(["sdf-active"], "{time_limit: 0.4}")
    return [
        Trial(method, SceneCase(f"table-{seed}", "table", seed=seed))
        for seed in (1, 4)
    ]


@pytest.fixture
def make_result() -> Callable[..., TrialResult]:
    """Hand-made results; `text` and `authors` are outcomes."""

    def make(
        method: str = "sdf-hard",
        scene: str = "a",
        text: str = SUCCESS,
        authors: str = SUCCESS,
        distance: float = 0.1,
        **fields,
    ) -> TrialResult:
        def judgement(outcome: str) -> Judgement:
            return Judgement(outcome, 3.0, distance, 0.02, 0.4, 0.5, 0.7, 0.3)

        head = {
            "key": f"{method}-{scene}",
            "family": "table",
            "spheres": "paper",
            "gains": "paper",
            "oracle": "GroundTruth",
            "splat": "none",
            "splat_count": 0,
            "station": "kinematic",
            "seed": 0,
            "version": "0",
            "text": judgement(text),
            "authors": judgement(authors),
            "times": WallTimes(2e-4, 1e-5, 1e-3, 2e-3, 1.0),
        }
        return TrialResult(method=method, scene=scene, **(head | fields))

    return make
