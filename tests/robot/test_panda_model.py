"""The shipped Panda: Frankie's arm on a fixed base, of the same files."""

import numpy as np
import pytest

from remosplat_drake.base import resources
from remosplat_drake.base.errors import FieldError
from remosplat_drake.robot.robot_description import load_robot_description
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.robot.sphere_model import load_sphere_model
from remosplat_drake.robot.visuals import load_visuals

MOUNT = np.array([0.15, 0, 0.38])
"""Where Frankie carries the arm."""


@pytest.fixture(scope="module", params=["covering", "paper"])
def robots(request):
    return load_robot("panda", request.param), load_robot(
        "frankie", request.param
    )


def test_it_has_an_arms_configuration_and_command(robots):
    panda, frankie = robots
    assert (panda.n_q, panda.n_u, panda.n_base) == (7, 7, 0)
    np.testing.assert_array_equal(
        panda.velocity_limit, frankie.velocity_limit[2:]
    )
    np.testing.assert_array_equal(
        panda.acceleration_limit, frankie.acceleration_limit[2:]
    )
    np.testing.assert_array_equal(
        panda.position_upper, frankie.position_upper[3:]
    )


def test_its_spheres_and_hand_are_where_frankies_are(robots):
    panda, frankie = robots
    rng = np.random.default_rng(0)
    arm = rng.uniform(panda.position_lower, panda.position_upper)
    q = np.array([0, 0, 0, *arm])
    ours, theirs = panda.spheres_at(arm), frankie.spheres_at(q)
    on_arm = ~frankie.spheres.on_links({"base_link"})
    assert len(ours) == on_arm.sum() == 61
    np.testing.assert_allclose(
        ours.p_WS + MOUNT, theirs.p_WS[on_arm], atol=1e-12
    )
    np.testing.assert_array_equal(ours.radius, theirs.radius[on_arm])
    X_WE = panda.end_effector_pose(arm)
    X_WE[:3, 3] += MOUNT
    np.testing.assert_allclose(X_WE, frankie.end_effector_pose(q), atol=1e-12)


def test_only_the_foot_stands_on_the_table():
    panda = load_robot("panda", floor_height=0.03)
    sees_all = panda.spheres_at(panda.home).ignore_below == -np.inf
    foot = panda.spheres.on_links({"panda_link0"})
    np.testing.assert_array_equal(sees_all, ~foot)


def test_what_frankie_includes_is_shipped_once():
    models = resources.models_dir()
    for name in ("panda.urdf", "panda_hand.urdf", "collision/panda_hand_0.obj"):
        holders = [f.relative_to(models) for f in models.glob(f"*/{name}")]
        assert [f.parts[0] for f in holders] == ["panda"]
    meshes = {
        name: load_visuals(models / name / "visuals.yaml")
        for name in ("frankie", "panda")
    }
    assert set(meshes["frankie"]) - set(meshes["panda"]) == {"base_link"}
    home = load_robot_description("panda").home
    assert len(home) == 7


SPHERES = "spheres: {arm: [[0, 0, 0, 1]]}\n"


@pytest.mark.parametrize(
    ("include", "other", "complaint"),
    [
        ("absent.yaml", SPHERES, "include: absent.yaml: no such file"),
        ("other.yaml", SPHERES, "spheres.arm: is in .*other.yaml, too"),
        (
            "other.yaml",
            f"include: a.yaml\n{SPHERES}",
            "include: .*other.yaml must not include a further file",
        ),
    ],
)
def test_bad_includes_are_named(tmp_path, include, other, complaint):
    path = tmp_path / "a.yaml"
    path.write_text(f"include: {include}\n{SPHERES}")
    (tmp_path / "other.yaml").write_text(other)
    with pytest.raises(FieldError, match=complaint) as error:
        load_sphere_model(path)
    assert str(error.value).startswith(str(path))


def test_included_spheres_come_after_ones_own(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text(f"include: other.yaml\n{SPHERES}")
    other = tmp_path / "other.yaml"
    other.write_text("spheres: {hand: [[0, 0, 1, 0.5]]}")
    model = load_sphere_model(path)
    assert model.name == "a"
    assert model.links == ("arm", "hand")
    np.testing.assert_array_equal(model.radius, [1, 0.5])
