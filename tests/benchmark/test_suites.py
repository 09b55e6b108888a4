"""Suites: where scenes and splats come from."""

import pytest
from own_cache import use_cache

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark import suites
from remosplat_drake.benchmark.reaching_task import SURFEL, TRAINED
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.suites import interleave_families, load_suite
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.rmmi import write_rmmi
from remosplat_drake.splat.codecs.ply import write_ply


@pytest.fixture
def published(tmp_path, monkeypatch):
    """Two scenes of each family in the published layout."""
    use_cache(monkeypatch, tmp_path / "cache")
    for family, stem in suites.PUBLISHED_FOLDERS.items():
        (tmp_path / stem).mkdir()
        (tmp_path / stem / "generator.json").write_text("{}")
        for i in range(2):
            path = tmp_path / stem / f"{stem}_{i:04d}.json"
            write_rmmi(path, generate(family, i))
    return tmp_path


def test_families_take_turns():
    names = [("a", 1), ("a", 2), ("a", 3), ("b", 1)]
    cases = [SceneCase(f"{family}{i}", family) for family, i in names]
    order = [case.name for case in interleave_families(cases)]
    assert order == ["a1", "b1", "a2", "a3"]


def test_published_scenes_come_family_by_family(published):
    cases = load_suite(f"published:{published}", 1)
    assert [c.name for c in cases] == [
        "table_new_0000",
        "bookshelf_cage_0000",
    ]
    assert [c.family for c in cases] == ["table", "bookshelf"]
    expected = generate("table", 0).content_hash
    assert cases[0].truth().content_hash == expected
    assert len(load_suite(f"published:{published}", 500)) == 4


def test_a_splat_is_found_by_name_or_content(published):
    folder = published / "splats"
    folder.mkdir()
    splat = surfel_splat(generate("table", 0), 500)
    write_ply(folder / "table_0000.ply", splat)
    by_content = generate("table", 1).content_hash
    write_ply(folder / f"{by_content}.ply", splat)
    name = f"published:{published}"
    cases = load_suite(name, 2, (folder,))
    origins = [c.splat()[1] for c in cases]
    assert origins == [TRAINED, TRAINED, SURFEL, SURFEL]
    trained = load_suite(name, 2, (folder,), trained_only=True)
    assert [c.name for c in trained] == ["table_new_0000", "table_new_0001"]
    with pytest.raises(RemoSplatError, match="has no scenes"):
        load_suite(name, 2, (), trained_only=True)


def test_generated_scenes_are_the_feasible_ones(monkeypatch):
    monkeypatch.setattr(
        suites, "feasible_seeds", lambda family, count, *_: [3, 5, 8][:count]
    )
    cases = load_suite("generated", 2)
    assert [c.name for c in cases] == [
        "table-v1-0003",
        "table-v1-0005",
        "bookshelf-v1-0003",
        "bookshelf-v1-0005",
    ]
    assert "goal-feasible v1 (covering spheres, 21 mm)" in cases[0].suite
    assert cases[1].truth().content_hash == generate("table", 5).content_hash


def test_generated_families_can_be_chosen(monkeypatch):
    monkeypatch.setattr(
        suites, "feasible_seeds", lambda family, count, *_: [2, 4][:count]
    )
    cases = load_suite("generated:posts,table", 1)
    assert [c.name for c in cases] == ["table-v1-0002", "posts-v1-0002"]
    with pytest.raises(RemoSplatError, match="did you mean 'posts'"):
        load_suite("generated:post", 1)


def test_unknown_suites_and_empty_folders(tmp_path):
    with pytest.raises(RemoSplatError, match="valid: generated, generated:"):
        load_suite("others", 1)
    with pytest.raises(RemoSplatError, match="table_new"):
        load_suite(f"published:{tmp_path}", 1)
