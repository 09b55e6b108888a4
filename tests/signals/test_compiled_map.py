"""Maps asked from compiled code, held against the same asked from Python."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from remosplat_drake.base.kernels import kernel
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.compiled_map import query_map
from remosplat_drake.signals.distance_field import DistanceField


def fields() -> dict[str, DistanceField]:
    scene = generate("table", 3)
    unseen = np.random.default_rng(5).random((9, 8, 7)) < 0.3
    parts = {
        "octree": UnknownSpaceField(unseen, np.array([0.2, -0.8, 0.0]), 0.2),
        "primitives": SignedDistanceField(scene),
        "splat": SphereToEllipsoidField(surfel_splat(scene)),
    }
    nothing = SphereToEllipsoidField(surfel_splat(scene).select([]))
    return parts | {
        "all": CompositeDistanceField([*parts.values(), nothing]),
        "empty splat": nothing,
    }


FIELDS = fields()


@kernel
def asked(compiled, question, answer):
    query_map(compiled, question, answer)


@pytest.mark.parametrize("name", sorted(FIELDS))
@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), reach=st.sampled_from([0.05, 0.4, 5.0]))
def test_kernels_hear_the_distances_that_python_hears(name, seed, reach):
    field = FIELDS[name]
    rng = np.random.default_rng(seed)
    n = 12
    spheres = Spheres(
        rng.uniform([0, -1, -0.2], [2, 1, 1.5], (n, 3)),
        np.tile(np.eye(3), (n, 1, 1)),
        rng.uniform(0.02, 0.2, n),
        np.where(rng.random(n) < 0.3, 0.1, -np.inf),
    )
    question = np.column_stack(
        [spheres.p_WS, spheres.radius + reach, spheres.ignore_below]
    )
    answer = np.empty((n, 8))
    asked(field.compiled, question, answer)
    distance = np.where(
        answer[:, 0] >= 0, answer[:, 1] - spheres.radius, np.inf
    )
    expected = field.clearances(spheres, reach).per_sphere(n)
    np.testing.assert_allclose(distance, expected, rtol=0, atol=1e-12)


def test_a_composite_with_a_part_that_no_kernel_can_ask_has_none_itself():
    class OnlyPython(DistanceField):
        revision = "none"

        def clearances(self, spheres, max_distance=np.inf):
            raise NotImplementedError

    parts = [FIELDS["splat"], OnlyPython()]
    assert CompositeDistanceField(parts).compiled is None


MINE = """
from typing import NamedTuple
import numpy as np
from remosplat_drake.base.kernels import kernel
from remosplat_drake.base.kernels.packed import Packed
from remosplat_drake.signals.compiled_map import register_query, clearance_rows
from remosplat_drake.signals.compiled_map import together

class Plane(NamedTuple):
    height: float

@kernel
def query(plane, spheres, answer):
    for i in range(len(answer)):
        answer[i] = 0.0
        answer[i, 1] = spheres[i, 2] - plane.height

register_query(Plane, query)
maps = together([Packed(Plane(0.5))])
zeros, alone = np.zeros(1), np.full(1, -1)
free = zeros - np.inf
found = clearance_rows(maps, np.ones((1, 3)), zeros, free, alone, np.inf)
asked = (clearance_rows, query)
print(found[1][0], *(int(k.variants[0].was_kept) for k in asked))
"""
"""Prints a distance to a map from outside, and whether the library's kernel
that has asked it was on disk, and that of the map."""


def test_a_map_from_outside_is_asked_as_its_file_is_now(tmp_path):
    """The library's kernels call its kernel by address, and are kept."""
    path = tmp_path / "mine.py"

    def answer() -> str:
        result = subprocess.run(
            [sys.executable, "-c", "import mine"],
            env=os.environ
            | {
                "PYTHONPATH": f"{Path(__file__).parents[2]}:{tmp_path}",
                "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
            },
            capture_output=True,
            text=True,
            check=True,
        )
        return result.stdout

    path.write_text(MINE)
    assert answer() == "0.5 0 0\n"
    assert answer() == "0.5 1 1\n"
    path.write_text(MINE.replace("- plane", "+ plane"))
    assert answer() == "1.5 1 0\n"
