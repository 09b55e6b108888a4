"""The sphere model file: what it means, and that bad ones are named."""

import copy

import numpy as np
import pytest

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.robot.sphere_model import Spheres, load_sphere_model

SPHERES = resources.models_dir() / "frankie" / "spheres"


def write(tmp_path, text):
    path = tmp_path / "two.yaml"
    path.write_text(text)
    return path


def test_reads_links_centres_and_radii(tmp_path):
    path = write(
        tmp_path,
        "spheres:\n  foot: [[0, 0, 1, 0.5]]\n  arm: [[1, 2, 3, 0.25]]\n",
    )
    model = load_sphere_model(path)
    assert model.name == "two"
    assert model.links == ("foot", "arm")
    np.testing.assert_array_equal(model.p_LS, [[0, 0, 1], [1, 2, 3]])
    np.testing.assert_array_equal(model.radius, [0.5, 0.25])
    np.testing.assert_array_equal(model.on_links({"arm"}), [False, True])
    assert copy.deepcopy(model) is model


@pytest.mark.parametrize(
    ("entry", "problem"),
    [
        ("[0, 0, 0]", "expected"),
        ("[0, 0, 0, -1]", "positive"),
        ("[0, 0, 0, 0]", "positive"),
        ("[0, 0, .nan, 1]", "finite"),
        ("[0, 0, true, 1]", "expected"),
        ("[0, 0, '0', 1]", "expected"),
        ("7", "expected"),
    ],
)
def test_bad_sphere_is_named(tmp_path, entry, problem):
    path = write(tmp_path, f"spheres:\n  arm: [[0, 0, 0, 1], {entry}]\n")
    with pytest.raises(FieldError, match=problem) as error:
        load_sphere_model(path)
    assert "spheres.arm[1]" in str(error.value)


@pytest.mark.parametrize(
    "text", ["", "[]", "spheres: 3", "spheres: {}", "a: [", "\t"]
)
def test_bad_file_is_named(tmp_path, text):
    with pytest.raises(RemoSplatError, match=r"two\.yaml"):
        load_sphere_model(write(tmp_path, text))


def test_missing_file_is_named(tmp_path):
    with pytest.raises(FileError, match="absent"):
        load_sphere_model(tmp_path / "absent.yaml")


@pytest.mark.parametrize("name", ["covering", "paper"])
def test_shipped_sets_load(name):
    model = load_sphere_model(SPHERES / f"{name}.yaml")
    assert 70 <= len(model) <= 90
    assert {"base_link", "panda_hand"} <= set(model.links)


def test_spheres_at_points_see_everything_and_can_be_selected():
    spheres = Spheres.at(np.eye(3), radius=0.1)
    assert len(spheres) == 3
    assert (spheres.ignore_below == -np.inf).all()
    last = spheres.select(np.array([False, False, True]))
    np.testing.assert_array_equal(last.p_WS, [[0, 0, 1]])
