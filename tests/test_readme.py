"""The README keeps its word: commands run, examples load, links lead on."""

import importlib
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.app.scenario import load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.main import COMMANDS, main
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()

# Appended to a command of the README so that it takes only a moment. What is
# not listed here is parsed, but not carried out.
SHORTER = {
    "scenarios": [],
    # What so small a capture makes is a poor map.
    "run": ["--headless", "--accept", "map-error"],
    "teleop": [
        "--headless",
        "--duration",
        "0.3",
        "--trajectory",
        "script.yaml",
    ],
    "fit-spheres": ["--count", "6"],
    "render-capture": ["--views", "12", "--width", "120", "--height", "90"],
    "reconstruct": ["--count", "3000", "--held-out", "4", "--device", "cpu"],
}
# Programs that are not ours to test.
FOREIGN = {"cd", "git", "pip"}


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", README, re.M | re.S)


def command_lines(block: str) -> list[list[str]]:
    lines = block.replace("\\\n", " ").splitlines()
    words = [shlex.split(line, comments=True) for line in lines]
    return [line for line in words if line]


@pytest.fixture(scope="module")
def a_capture(rendering, tmp_path_factory) -> Path:
    """What the README's reader has taken of a table."""
    folder = tmp_path_factory.mktemp("a") / "capture"
    scene = str(models_dir() / "scenes/table/scene.json")
    shorter = SHORTER["render-capture"]
    assert (
        main(["render-capture", scene, str(folder), "--floor", *shorter]) == 0
    )
    return folder


@pytest.fixture
def folder(a_capture, tmp_path, monkeypatch) -> Path:
    """Where the README's reader stands, with the files that it mentions."""
    n = 50
    rng = np.random.default_rng(0)
    write_ply(
        tmp_path / "kitchen.ply",
        GaussianSplat(
            p_GK=rng.uniform((-1, -1, 2.2), (1, 1, 2.3), (n, 3)),
            quaternions=rng.normal(size=(n, 4)),
            scales=np.full((n, 2), 0.02),
            opacities=np.full(n, 0.9),
            colors=np.full((n, 3), 0.5),
        ),
    )
    (tmp_path / "script.yaml").write_text("steps: [{press: home}]\n")
    (tmp_path / "my_scenarios.yaml").write_text("".join(blocks("yaml")))
    shutil.copy(ROOT / "tests/data/three_link.urdf", tmp_path / "my_arm.urdf")
    shutil.copy(models_dir() / "scenes/table/scene.json", tmp_path)
    shutil.copytree(a_capture, tmp_path / "my_capture")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def carry_out(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs one command line of ours, shortened, or at least parses it."""
    command = arguments[0]
    assert command in COMMANDS
    # Nobody has a robot at hand.
    if command not in SHORTER or "--hardware" in arguments:
        module = importlib.import_module(
            f"remosplat_drake.commands.{command.replace('-', '_')}"
        )
        monkeypatch.setattr(module, "run", lambda arguments: 0)
        assert main(arguments) == 0
        return
    arguments = [*arguments, *SHORTER[command]]
    if command == "run":
        shorter = "time_limit: 0.1}"
        if "--scenario-text" in arguments:
            at = arguments.index("--scenario-text") + 1
            text = arguments[at].rstrip().removesuffix("}")
            arguments[at] = f"{text}, {shorter}"
        else:
            arguments += ["--scenario-text", "{" + shorter]
    if command == "teleop" and "--session" not in arguments:
        # Two may begin in one second.
        arguments += ["--session", str(len(list(Path().iterdir())))]
    # The moment does not suffice to reach anything.
    assert main(arguments) == (1 if command == "run" else 0)


@pytest.mark.parametrize("block", blocks("sh"))
def test_every_command_works(folder, block, monkeypatch):
    targets = set(
        re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M)
    )
    for program, *arguments in command_lines(block):
        if program == "make":
            assert arguments[0] in targets
        elif program == "remosplat":
            carry_out(arguments, monkeypatch)
        else:
            assert program in FOREIGN, f"nobody tests {program!r}"


def test_the_main_job_is_among_the_commands():
    lines = [line for block in blocks("sh") for line in command_lines(block)]
    assert ["make", "run"] in lines
    assert any(line[:2] == ["remosplat", "run"] for line in lines)


@pytest.mark.parametrize("example", blocks("yaml"))
def test_every_scenario_loads(folder, example):
    file = folder / "example.yaml"
    file.write_text(example)
    for name in re.findall(r"^(\w+):", example, re.M):
        world = load_world(load_scenario(f"{file}:{name}"))
        assert world.splat_W is not None


def test_every_tag_is_one_of_a_scenario(folder):
    for tag in set(re.findall(r"!([A-Z]\w+)", README)):
        field = "station" if tag.endswith("Station") else "oracle"
        text = f"{{{field}: !{tag} {{}}}}"
        scenario = load_scenario(override=text)
        assert type(getattr(scenario, field)).__name__ == tag


def test_every_relative_link_leads_somewhere():
    links = re.findall(r"\]\(([^)#\s]+)", README)
    missing = [
        link
        for link in links
        if "://" not in link and not (ROOT / link).exists()
    ]
    assert links
    assert missing == []


def test_every_folder_that_is_explained_exists():
    rows = re.findall(r"^\| (`[a-z_]+/.*?) \|", README, re.M)
    folders = [name for row in rows for name in re.findall(r"`(.*?)`", row)]
    assert folders
    package = ROOT / "remosplat_drake"
    assert [name for name in folders if not (package / name).exists()] == []
