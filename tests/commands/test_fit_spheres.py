"""`fit-spheres` from flags to file."""

import argparse

import pytest

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.commands import fit_spheres
from remosplat_drake.robot.sphere_model import load_sphere_model

URDF = """
<robot name="toy"><link name="ball"><collision>
  <geometry><sphere radius="0.5"/></geometry>
</collision></link></robot>
"""


def run(*flags):
    parser = argparse.ArgumentParser()
    fit_spheres.add_arguments(parser)
    return fit_spheres.run(parser.parse_args([str(flag) for flag in flags]))


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "toy.urdf"
    path.write_text(URDF)
    return path


def test_writes_a_model_that_loads(model, tmp_path, capsys):
    output = tmp_path / "out" / "ball.yaml"
    assert run(model, "--count", 1, "--output", output) == 0
    spheres = load_sphere_model(output)
    assert spheres.links == ("ball",)
    assert spheres.radius[0] == pytest.approx(0.5, abs=0.02)
    assert "ball" in capsys.readouterr().out


def test_fits_one_link_of_a_shipped_robot(capsys):
    flags = ("--links", "panda_leftfinger", "--count", 4)
    assert run("frankie", *flags) == 0
    assert "panda_leftfinger" in capsys.readouterr().out


@pytest.mark.parametrize("weight", ["ball", "ball=", "ball=-1", "ball=nan"])
def test_bad_weight_is_named(model, weight):
    with pytest.raises(FieldError, match="LINK=FACTOR"):
        run(model, "--weight", weight)


def test_a_bare_model_file_has_no_meshes(model):
    with pytest.raises(RemoSplatError, match="names no meshes"):
        run(model, "--meshes")


BOX_AND_BALL = """
<robot name="toy">
  <link name="ball"><collision>
    <geometry><sphere radius="0.1"/></geometry>
  </collision></link>
  <link name="stick"><collision>
    <geometry><box size="0.05 0.05 0.6"/></geometry>
  </collision></link>
  <joint name="j" type="fixed"><parent link="ball"/><child link="stick"/>
  <origin xyz="5 0 0"/></joint>
</robot>
"""


def test_a_tolerance_spends_spheres_where_they_stand_out(tmp_path, capsys):
    model, output = tmp_path / "toy.urdf", tmp_path / "spheres.yaml"
    model.write_text(BOX_AND_BALL)
    assert run(model, "--tolerance", 25, "--output", output) == 0
    spheres = load_sphere_model(output)
    assert spheres.links.count("ball") == 1
    assert spheres.links.count("stick") >= 4
    # A sphere's centre is inside the stick, 25 mm deep at most.
    assert spheres.on_link("stick").radius.max() < 0.025 + 0.025 + 0.005
    assert "--tolerance 25" in output.read_text()
    assert "max bulge" in capsys.readouterr().out


def test_the_most_spheres_of_a_link_are_the_users_choice(model, tmp_path):
    sphere, box = '<sphere radius="0.5"/>', '<box size="0.1 0.1 0.2"/>'
    model.write_text(URDF.replace(sphere, box))
    output = tmp_path / "spheres.yaml"
    flags = ["--tolerance", 2, "--most", 3, "--output", output]
    assert run(model, *flags) == 0
    assert "--tolerance 2 --most 3" in output.read_text()
    assert len(load_sphere_model(output).links) <= 3


@pytest.mark.parametrize(
    ("flags", "message"),
    [
        (["--most", 3], "needs --tolerance"),
        (["--tolerance", 2, "--most", 0], "expected 1 to 200, got 0"),
    ],
)
def test_a_most_that_says_nothing_is_refused(model, flags, message):
    with pytest.raises(FieldError, match=f"--most: {message}"):
        run(model, *flags)


@pytest.mark.parametrize("tolerance", ["0", "-3", "1e9"])
def test_a_tolerance_beyond_reason_is_refused(model, tolerance):
    with pytest.raises(FieldError, match=r"--tolerance: expected 0.5 to 200"):
        run(model, "--tolerance", tolerance)


def test_a_count_and_a_tolerance_exclude_each_other(model):
    with pytest.raises(RemoSplatError, match="not with --count"):
        run(model, "--tolerance", 10, "--count", 5)
