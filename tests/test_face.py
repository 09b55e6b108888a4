"""The library's face: which names it has, where they are, what they cost."""

import ast
import doctest
import subprocess
import sys
from pathlib import Path

import pytest

import remosplat_drake as rs

# Users rely on these names: adding one is a promise, dropping one breaks it.
FACE = frozenset(
    """
    AddViews Application Clearances CompiledIngredient Config DepthRasterization
    DistanceField DistanceOracle GaussianSplat GroundTruth GuidanceSelector
    Ingredient MeshcatPage ReactiveController ReactiveLaw ReactiveProgram
    RemoSplatError RobotModel SafetySupervisor Scenario SphereToEllipsoid Target
    TargetSequence Tick add_rate build default_ingredients load_robot
    load_scenario new_row read_scene read_splat run
    """.split()
)


def declared() -> dict[str, str]:
    """What type checkers are told: each name, and the module it is from."""
    tree = ast.parse(Path(rs.__file__).read_text())
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    return {
        alias.name: node.module.removeprefix("remosplat_drake.")
        for node in block.body
        if isinstance(node, ast.ImportFrom) and node.module
        for alias in node.names
    }


def test_the_face_is_frozen():
    assert set(rs.__all__) == FACE | {"__version__"}
    assert set(dir(rs)) >= FACE


def test_type_checkers_are_told_the_same():
    assert declared() == rs._MODULES


@pytest.mark.parametrize("name", sorted(FACE))
def test_every_name_is_there_and_has_its_home(name):
    value = getattr(rs, name)
    assert value.__module__ == f"remosplat_drake.{rs._MODULES[name]}"
    assert value.__name__ == name


@pytest.mark.parametrize("name", sorted(FACE))
def test_every_name_is_documented_with_an_example_that_runs(
    name, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    value = getattr(rs, name)
    parser = doctest.DocTestParser()
    example = parser.get_doctest(value.__doc__, {"rs": rs}, name, None, None)
    assert example.examples, "no example"
    failed, _ = doctest.DocTestRunner(
        optionflags=doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    ).run(example)
    assert not failed


def test_an_unknown_name_is_refused_as_python_does():
    with pytest.raises(AttributeError, match="has no attribute 'kitchen'"):
        _ = rs.kitchen


def test_importing_the_face_loads_next_to_nothing():
    program = (
        "import sys; before = set(sys.modules); import remosplat_drake;"
        "new = set(sys.modules) - before;"
        "print(*{'numpy', 'numba', 'pydrake', 'yaml', 'scipy'} & new)"
    )
    answer = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
    )
    assert answer.stdout.split() == []
