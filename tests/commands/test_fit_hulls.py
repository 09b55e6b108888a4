"""`fit-hulls` from flags to files that Drake reads."""

import argparse

import numpy as np
import pytest
from pydrake.geometry import Convex
from scipy.spatial import ConvexHull

from remosplat_drake.base import resources
from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.commands import fit_hulls
from remosplat_drake.robot.meshes import source_mesh

FINGER = "panda_leftfinger"
SHIPPED = resources.models_dir() / "panda" / "collision"


def run(*flags):
    parser = argparse.ArgumentParser()
    fit_hulls.add_arguments(parser)
    return fit_hulls.run(parser.parse_args([str(flag) for flag in flags]))


@pytest.fixture
def meshes():
    if (
        source_mesh("xacro/qut_frankie_description/meshes/visual/hand.dae")
        is None
    ):
        pytest.skip("needs the extra `meshes`")


def corners(path) -> np.ndarray:
    """The corners of a convex shape, shape (n, 3) [m]."""
    hull = Convex(str(path)).GetConvexHull()
    return np.array([hull.vertex(i) for i in range(hull.num_vertices())])


def most_outside(p: np.ndarray, other: np.ndarray) -> float:
    """How far points are outside the convex hull of others, at most [m]."""
    planes = ConvexHull(other).equations
    return float((p @ planes[:, :3].T + planes[:, 3]).max())


def test_the_shipped_shapes_are_what_it_makes(meshes, tmp_path, capsys):
    flags = ("--links", FINGER, "--tolerance", 0.3, "--output", tmp_path / "a")
    assert run("frankie", *flags) == 0
    files = sorted(tmp_path.glob("a/*.obj"))
    assert len(files) == 3
    for file in files:
        made, shipped = (corners(path) for path in (file, SHIPPED / file.name))
        # Both leave no point of the mesh farther outside than 0.3 mm.
        assert most_outside(made, shipped) < 0.6e-3
        assert most_outside(shipped, made) < 0.6e-3
    elements = (tmp_path / "a" / "shapes.xml").read_text()
    assert 'filename="a/panda_leftfinger_2.obj"' in elements
    assert FINGER in capsys.readouterr().out


def test_spheres_that_enclose_too_little_are_named(meshes):
    flags = ("--spheres", "paper", "--links", "panda_link7")
    with pytest.raises(RemoSplatError, match="panda_link7: the mesh protrudes"):
        run("frankie", *flags)


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (("franky",), "did you mean 'frankie'"),
        (("frankie", "--spheres", "x"), "unknown sphere set 'x'"),
        (("frankie", "--links", "panda_hnad"), "did you mean 'panda_hand'"),
        (("frankie", "--tolerance", "0"), "--tolerance: 0.0"),
        (("frankie", "--tolerance", "nan"), "--tolerance: nan"),
        (("tests/data/three_link.yaml",), "names no meshes"),
    ],
)
def test_bad_flags_are_named(flags, problem):
    with pytest.raises(RemoSplatError, match=problem):
        run(*flags)
