"""The `covering` set hides no part of Frankie from the controller."""

from functools import cache

import numpy as np
import pytest

from remosplat_drake import resources
from remosplat_drake.errors import MissingExtraError
from remosplat_drake.robot.link_spheres import LinkSpheres, measure_bulge
from remosplat_drake.robot.model_surfaces import SurfaceOptions, model_surfaces
from remosplat_drake.robot.sphere_model import load_sphere_model

FOLDER = resources.models_dir() / "frankie"
LINKS = [
    "base_link",
    *(f"panda_link{i}" for i in range(8)),
    "panda_hand",
    "panda_leftfinger",
    "panda_rightfinger",
]


@cache
def covering() -> dict[str, LinkSpheres]:
    model = load_sphere_model(FOLDER / "spheres" / "covering.yaml")
    return {
        link: LinkSpheres(model.p_LS[mask], model.radius[mask])
        for link in LINKS
        if (mask := model.on_links({link})).any()
    }


@cache
def shapes():
    """The collision shapes; drawn with a seed that no fit has seen."""
    return model_surfaces(FOLDER / "frankie.dmd.yaml", SurfaceOptions(), 17)


@cache
def meshes():
    try:
        return model_surfaces(
            FOLDER / "frankie.dmd.yaml",
            SurfaceOptions(visuals=FOLDER / "visuals.yaml"),
            17,
        )
    except MissingExtraError as error:
        pytest.skip(str(error))


def test_every_link_has_spheres_and_shapes():
    assert set(covering()) == set(LINKS) == set(shapes())


def test_all_of_the_base_is_covered():
    points = shapes()["base_link"].points
    assert np.mean(covering()["base_link"].outside(points) <= 0) == 1.0


@pytest.mark.parametrize("link", LINKS)
def test_collision_shapes_stand_out_by_their_corners_at_most(link):
    # The spheres cover the meshes. The shapes of arm and hand are boxes and
    # cylinders around round covers; without the meshes this is a rough check.
    outside = covering()[link].outside(shapes()[link].points)
    assert np.mean(outside <= 0) > 0.5
    assert outside.max() < 0.045


@pytest.mark.parametrize("link", LINKS)
def test_all_of_the_mesh_is_covered(link):
    points = meshes()[link].points
    assert np.mean(covering()[link].outside(points) <= 0) == 1.0


@pytest.mark.parametrize("link", LINKS)
def test_no_mesh_stands_out_of_its_collision_shapes(link):
    points = meshes()[link].points
    if link == "base_link":  # Its shapes end above the floor, see the URDF.
        points = points[points[:, 2] > 0.005]
    solid = shapes()[link].solid
    assert solid.depth_at(points).min() > -1.5 * solid.pitch


def test_fingertips_stay_slim():
    # A gripper works next to things: see how far its spheres stand out.
    for link in ("panda_leftfinger", "panda_rightfinger"):
        solid = shapes()[link].solid
        assert measure_bulge(covering()[link], solid).max < 0.012
