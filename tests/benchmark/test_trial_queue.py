"""What runs next, and who waits for what."""

import pytest

from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.splat_recipe import SplatRecipe
from remosplat_drake.benchmark.suites import SceneCase
from remosplat_drake.benchmark.trained_splats import SplatOrder
from remosplat_drake.benchmark.trial import Trial
from remosplat_drake.benchmark.trial_queue import (
    SplatMaking,
    TrialQueue,
    interleave_families,
)


@pytest.fixture
def scenes() -> list[Trial]:
    """Three scenes, two methods in each; only one looks at a splat."""
    methods = load_methods(["sdf-active", "ellipsoid-active"])
    cases = [SceneCase(f"t-{i}", "table", seed=i) for i in range(3)]
    return [Trial(method, case) for case in cases for method in methods]


def queue_of(trials, workers, at_once, known=()):
    making = SplatMaking(SplatRecipe(), at_once)
    return TrialQueue(trials, known, workers, splats=making)


def label(job) -> str:
    if job is None:
        return ""
    if isinstance(job.subject, SplatOrder):
        return f"splat {job.subject.case.name}"
    return job.subject.label


def test_families_take_turns():
    names = [("a", 1), ("a", 2), ("a", 3), ("b", 1)]
    cases = [SceneCase(f"{family}{i}", family) for family, i in names]
    order = [case.name for case in interleave_families(cases)]
    assert order == ["a1", "b1", "a2", "a3"]


def test_one_worker_is_left_for_trials(scenes):
    queue = queue_of(scenes, workers=2, at_once=2)
    assert (queue.splats_left, queue.trials_left) == (3, 6)
    first, second = queue.take(), queue.take()
    assert [label(first), label(second)] == ["splat t-0", "splat t-1"]
    # Both workers are taken by splats; the third must wait.
    assert queue.take() is None
    queue.done(first, None)
    # Only one of two workers may make splats while trials are ready.
    assert label(queue.take()) == "sdf-active in t-0"
    assert label(queue.take()) == "ellipsoid-active in t-0"
    assert label(queue.take()) == "splat t-2"
    assert (queue.splats_left, queue.trials_left) == (0, 4)


def test_no_more_splats_at_once_than_allowed(scenes):
    queue = queue_of(scenes, workers=8, at_once=1)
    job = queue.take()
    assert label(job) == "splat t-0"
    assert queue.take() is None
    queue.done(job, None)
    assert label(queue.take()) == "splat t-1"
    assert label(queue.take()) == "sdf-active in t-0"


def test_in_one_process_a_scene_is_finished_before_the_next(scenes):
    queue = queue_of(scenes, workers=0, at_once=1)
    order = []
    while (job := queue.take()) is not None:
        order.append(label(job))
        queue.done(job, None)
    assert order[:4] == [
        "splat t-0",
        "sdf-active in t-0",
        "ellipsoid-active in t-0",
        "splat t-1",
    ]
    assert len(order) == 9


def test_scenes_that_need_no_splat_get_none(scenes):
    true_fields = [t for t in scenes if not t.method.needs_splat]
    queue = queue_of(true_fields, workers=4, at_once=2)
    assert (queue.splats_left, queue.trials_left) == (0, 3)
    known = [t.key() for t in true_fields[:2]]
    queue = queue_of(true_fields, workers=4, at_once=2, known=known)
    assert queue.trials_left == 1
    assert len(queue.keys) == 3
