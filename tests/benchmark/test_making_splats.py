"""Splats for a suite's scenes: made first and once, and kept."""

import dataclasses as dc
import json

import numpy as np
import pytest
from own_cache import use_cache

from remosplat_drake.base.errors import FieldError, FileError
from remosplat_drake.base.pool import gpu_for
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.reaching_task import SURFEL, TRAINED
from remosplat_drake.benchmark.result import read_results
from remosplat_drake.benchmark.runner import (
    SplatMaking,
    make_splats,
    missing_splats,
    run_trials,
)
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.splat_recipe import (
    REFINED,
    SplatRecipe,
    default_folders,
    load_recipe,
)
from remosplat_drake.benchmark.splat_record import (
    read_record,
    read_records,
    write_records,
)
from remosplat_drake.benchmark.splat_table import splat_table
from remosplat_drake.benchmark.trained_splats import (
    FITS,
    SplatOrder,
    failed_record,
    make_splat,
    make_splat_with,
    stored_records,
)
from remosplat_drake.benchmark.trial import Trial
from remosplat_drake.reconstruction.surfels.surfels import splat_of_surfels
from remosplat_drake.splat.codecs.ply import read_ply

TINY = SplatRecipe(views=6, width=64, height=48, count=500, steps=1)


def untrained(capture, surfels, recipe):
    """A real fit that needs no GPU: the discs as they were laid."""
    return splat_of_surfels(surfels)


def make_untrained(order: SplatOrder):
    return make_splat_with(untrained, order)


def fails_in_scene_1(order: SplatOrder):
    if order.case.seed == 1:
        raise ValueError("no such luck")
    return make_untrained(order)


def must_not_run(order: SplatOrder):
    raise AssertionError("it is there already")


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    use_cache(monkeypatch, tmp_path / "cache")


@pytest.fixture
def splat_trials(rendering, own_cache) -> list[Trial]:
    """Two scenes, with and without a splat, a few ticks each."""
    methods = load_methods(["sdf-active", "ellipsoid-active"], TICKS)
    folder = str(TINY.folder)
    return [
        Trial(
            method,
            SceneCase(f"t-{seed}", "table", seed=seed, splat_folders=(folder,)),
        )
        for seed in (1, 4)
        for method in methods
    ]


TICKS = "{time_limit: 0.2}"


def run(trials, path, function=make_untrained, jobs=0, recipe=TINY, **options):
    told = []
    records = make_splats(
        missing_splats(trials, recipe),
        SplatMaking(recipe, jobs),
        on_record=told.append,
        function=function,
        **options,
    )
    assert told == records
    return run_trials(trials, path, jobs, **options), records


@pytest.mark.parametrize("jobs", [0, pytest.param(2, marks=pytest.mark.slow)])
def test_scenes_get_splats_before_their_trials_run(
    tmp_path, splat_trials, jobs
):
    path = tmp_path / "trials.jsonl"
    results, records = run(splat_trials, path, jobs=jobs)
    assert not any(r.error for r in (*results, *records))
    assert {(r.scene, r.oracle, r.splat) for r in results} == {
        (scene, oracle, splat)
        for scene in ("t-1", "t-4")
        for oracle, splat in (
            ("GroundTruth", "none"),
            ("SphereToEllipsoid", TRAINED),
        )
    }
    for trial in splat_trials:
        file = TINY.splat_file(trial.case.truth())
        (of_scene,) = (r for r in records if r.scene == trial.case.name)
        assert read_record(file) == of_scene
        assert len(read_ply(file)) == of_scene.count > 100
        assert of_scene.quality["ellipsoid"].count > 100
        assert of_scene.quality["ellipsoid"].median < 0.05
    assert stored_records({t.case for t in splat_trials}, TINY)


@pytest.mark.slow
def test_what_is_there_is_not_made_again(tmp_path, splat_trials):
    path = tmp_path / "trials.jsonl"
    first, _ = run(splat_trials, path)
    again, records = run(splat_trials, path, must_not_run)
    assert not records
    assert again == first
    # Another recipe has a folder of its own, and needs splats of its own.
    other = dc.replace(TINY, steps=2)
    moved = [
        dc.replace(
            t, case=dc.replace(t.case, splat_folders=(str(other.folder),))
        )
        for t in splat_trials
    ]
    _, records = run(moved, path, recipe=other)
    assert len(records) == 2
    # Its trials are others, too, where the splat's content is.
    assert len(read_results(path)) == 4


def test_a_scene_without_luck_goes_on_with_surfels(tmp_path, splat_trials):
    path = tmp_path / "trials.jsonl"
    results, records = run(splat_trials, path, fails_in_scene_1)
    bad, good = records
    assert bad.error.endswith("ValueError: no such luck")
    assert (bad.scene, bad.count, bad.quality) == ("t-1", 0, {})
    assert not good.error
    assert [r.splat for r in results] == ["none", SURFEL, "none", TRAINED]
    # The next run tries again, and repeats only what depends on it.
    results, (record,) = run(splat_trials, path)
    assert not record.error
    assert [r.splat for r in results] == ["none", TRAINED, "none", TRAINED]
    assert len(read_results(path)) == 5


def over_after(looks: int):
    """Time that is up after so many looks at the clock."""
    left = iter(range(looks))
    return lambda: next(left, None) is None


def test_a_run_that_is_over_in_its_splats_goes_on(tmp_path, splat_trials):
    path = tmp_path / "trials.jsonl"
    results, records = run(splat_trials, path, is_over=over_after(1))
    assert not results
    assert [r.scene for r in records] == ["t-1"]
    # One look is at the splat that is left, the other at the first scene.
    results, records = run(splat_trials, path, is_over=over_after(2))
    assert [r.scene for r in records] == ["t-4"]
    assert [r.scene for r in results] == ["t-1", "t-1"]
    results, records = run(splat_trials, path)
    assert len(results) == 4
    assert not records


def test_only_scenes_that_are_looked_at_through_a_splat_get_one(splat_trials):
    orders = missing_splats(splat_trials, TINY)
    assert [order.case.name for order in orders] == ["t-1", "t-4"]
    blind = [t for t in splat_trials if not t.method.needs_splat]
    assert not missing_splats(blind, TINY)


def test_recipes_have_folders_of_their_own():
    assert TINY.folder == dc.replace(TINY).folder
    folders = {
        dc.replace(TINY, **{field: 7}).folder
        for field in ("views", "width", "height", "count", "steps", "seed")
    }
    assert len(folders | {TINY.folder}) == 7
    trained, refined = default_folders()
    assert trained == SplatRecipe().folder
    assert trained.name.startswith(TRAINED)
    assert refined.name.startswith(REFINED)
    assert load_recipe("cuda", "{steps: 3}") == SplatRecipe(steps=3)
    with pytest.raises(FieldError, match="since --train cuda sets it"):
        load_recipe("cuda", "{device: cpu}")
    with pytest.raises(FieldError, match=r"--recipe:1: views: .*\[1, 10000\]"):
        load_recipe("cuda", "{views: 0}")
    with pytest.raises(FieldError, match="did you mean 'steps'"):
        load_recipe("cuda", "{step: 3}")


def test_workers_take_turns_on_gpus():
    assert [gpu_for(i, ("0", "2", "5")) for i in range(5)] == [
        "0",
        "2",
        "5",
        "0",
        "2",
    ]


def test_the_table_of_splats_by_hand(tmp_path):
    def record(scene, median, over):
        head = failed_record(SplatOrder(SceneCase(scene, "table"), TINY), "")
        quality = {
            "depth": {
                "count": 9,
                "median": median,
                "percentile_99": 4e-3,
                "over": over,
                "under": 1e-3,
            }
        }
        fields = dc.asdict(head) | {"quality": quality, "count": 100}
        return json.dumps(fields | {"fit_seconds": 2.0})

    lines = [record("a", 1e-3, 5e-3), record("b", 3e-3, 7e-3)]
    path = tmp_path / "splats.jsonl"
    path.write_text("\n".join(lines) + "\n")
    records = read_records(path)
    failed = failed_record(SplatOrder(SceneCase("c", "table"), TINY), "oh")
    write_records(path, [*records, failed])
    assert read_records(path) == [*records, failed]
    table = splat_table(read_records(path))
    (row,) = table.rows
    cells = dict(zip(table.header, row, strict=True))
    assert (cells["made"], cells["failed"]) == ("2", "1")
    assert cells["recipe"] == "6 views 64 x 48, 1 steps"
    assert cells["discs"] == "100"
    assert cells["fit [s]"] == "2.0"
    assert cells["depth: median [mm]"] == "2.0"
    assert cells["depth: over [mm]"] == "7.0"
    assert splat_table([]) is None
    path.write_text("{}\n")
    with pytest.raises(FileError, match=r"splats\.jsonl"):
        read_records(path)


def test_refining_needs_no_gpu():
    recipe = dc.replace(TINY, device="cpu", views=12)
    case = SceneCase("t-1", "table", splat_folders=(str(recipe.folder),))
    record = make_splat(SplatOrder(case, recipe))
    assert record.origin == REFINED
    assert record.quality["ellipsoid"].median < 0.02
    splat, origin = case.splat()
    assert (len(splat), origin) == (record.count, REFINED)


@pytest.mark.gpu
def test_a_splat_is_trained_on_the_gpu():
    torch = pytest.importorskip("torch")
    pytest.importorskip("gsplat")
    if not torch.cuda.is_available():
        pytest.skip("needs a CUDA device")
    recipe = SplatRecipe(views=40, width=160, height=120, steps=300)
    assert recipe.device in FITS
    case = SceneCase("t-1", "table", seed=1)
    record = make_splat(SplatOrder(case, recipe))
    assert record.quality["ellipsoid"].median < 0.01
    splat = read_ply(recipe.splat_file(case.truth()))
    assert len(splat) == record.count
    assert np.isfinite(splat.p_GK).all()
