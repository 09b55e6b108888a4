"""`remosplat inspect` in a world of one wall: pictures, choices, mistakes."""

import numpy as np
import pytest
from PIL import Image

from remosplat_drake.commands.main import main
from remosplat_drake.recording.trajectory import Trajectory, save_trajectory
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

SCENARIO = """
Wall:
  scene: {splat: wall.ply}
  oracle: !DepthRasterization {resolution: 8}
  targets: [{translation: [1, 0, 1]}]
Nothing:
  targets: [{translation: [1, 0, 1]}]
"""


@pytest.fixture
def folder(tmp_path):
    """An opaque disc in the plane x = 1.2, before the robot."""
    wall = GaussianSplat(
        p_GK=np.array([[1.2, 0, 1.0]]),
        quaternions=np.array([[np.sqrt(0.5), 0, np.sqrt(0.5), 0]]),
        scales=np.array([[5.0, 5.0]]),
        opacities=np.array([0.99]),
        colors=np.full((1, 3), 0.5),
    )
    write_ply(tmp_path / "wall.ply", wall, with_normals=False)
    (tmp_path / "test.yaml").write_text(SCENARIO)
    return tmp_path


def inspect(folder, *flags: str, scenario: str = "Wall") -> int:
    return main(
        [
            "inspect",
            f"{folder}/test.yaml:{scenario}",
            *("--output", str(folder / "views.png")),
            *flags,
        ]
    )


def said(capfd) -> str:
    return " ".join(capfd.readouterr().err.split())


def test_the_nearest_sphere_of_all_is_shown(folder, frankie, capfd):
    assert inspect(folder) == 0
    q0 = np.array([0, 0, 0, *frankie.home])
    spheres = frankie.spheres_at(q0)
    clearance = 1.2 - spheres.p_WS[:, 0] - spheres.radius
    nearest = int(clearance.argmin())
    text = said(capfd)
    assert f"Sphere {nearest} on {frankie.spheres.links[nearest]}" in text
    # Eight pixels over 90 degrees are coarse: no ray hits the wall squarely.
    told = float(text.partition("clearance ")[2].split()[0])
    assert 0 <= told - 1e3 * clearance[nearest] < 10
    with Image.open(folder / "views.png") as picture:
        assert picture.size[0] > 1000
        # The wall is shaded from near to far.
        assert len(picture.convert("RGB").getcolors(10**6)) > 20
    assert sorted(p.name for p in folder.glob("*.png")) == ["views.png"]


def test_a_sphere_is_chosen_by_index_or_link(folder, frankie, capfd):
    assert inspect(folder, "--sphere", "30") == 0
    assert f"Sphere 30 on {frankie.spheres.links[30]}" in said(capfd)
    assert inspect(folder, "--sphere", "panda_link3") == 0
    assert "on panda_link3" in said(capfd)


def test_other_configurations_are_looked_from(folder, capfd):
    def clearance(*flags: str) -> float:
        assert inspect(folder, "--sphere", "panda_hand", *flags) == 0
        return float(said(capfd).partition("clearance ")[2].split()[0])

    q = np.zeros((3, 10))
    q[:, 0] = (0.0, 0.1, 0.2)
    save_trajectory(
        Trajectory(
            time=np.arange(2.0),
            q=q,
            u=np.zeros((2, 9)),
            status=np.array(["ok", "ok"]),
            scale=np.ones(2),
            clearance=np.ones(2),
            timings={},
        ),
        folder / "trajectory.npz",
    )
    flags = ("--trajectory", str(folder / "trajectory.npz"))
    here = clearance("--configuration", *("0",) * 10)
    assert clearance(*flags, "--tick", "0") == here
    assert clearance(*flags) == pytest.approx(here - 200, abs=5)
    assert clearance(*flags, "--tick", "1") == pytest.approx(here - 100, abs=5)


@pytest.mark.slow
def test_the_page_shows_the_rays(folder):
    page = folder / "page.html"
    assert inspect(folder, "--save-html", str(page)) == 0
    assert page.stat().st_size > 100_000


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        (("--sphere", "99"), "99 is not in 0 to"),
        (("--sphere", "panda_hnad"), "did you mean 'panda_hand'"),
        (("--configuration", "1", "2"), "expected 10 numbers"),
        (("--trajectory", "missing.npz"), "missing.npz"),
    ],
)
def test_mistakes_are_told_in_one_line(folder, capfd, flags, complaint):
    assert inspect(folder, *flags) == 2
    text = capfd.readouterr().err
    assert complaint in text
    assert text.count("\n") == 1
    assert not (folder / "views.png").exists()


def test_a_scenario_without_a_splat_cannot_be_inspected(folder, capfd):
    assert inspect(folder, scenario="Nothing") == 2
    assert "scene.splat" in said(capfd)
