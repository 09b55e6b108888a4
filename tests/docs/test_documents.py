"""The README, docs/ and `--help` keep their word: what they show works.

Commands are run, shortened where they take long, scenarios are loaded, Python
is executed and links lead somewhere. A block with a title is a file beside
the reader: the other blocks of its document may use it.
"""

import re
import shlex
import shutil
import sys
from collections import Counter
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from command_flags import reference_of_commands
from scenario_fields import reference_of

from remosplat_drake.app.scenario import Scenario, load_scenario
from remosplat_drake.app.world import load_world
from remosplat_drake.base.resources import models_dir
from remosplat_drake.commands.catalogue import GROUPS
from remosplat_drake.commands.command_parser import load_command
from remosplat_drake.commands.main import COMMANDS, main
from remosplat_drake.hardware.hardware_config import check_lcm_url
from remosplat_drake.splat.codecs.ply import write_ply
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.step_configs import AnyStep

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = (
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").rglob("*.md")),
)

# Appended to a command so that it takes only a moment. What is not listed
# here is parsed, but not carried out.
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
    "fit-spheres": ["--links", "wrist"],
    "render-capture": ["--views", "12", "--width", "120", "--height", "90"],
    "reconstruct": ["--count", "3000", "--held-out", "4", "--device", "cpu"],
}
# Programs that are not ours to test.
FOREIGN = {"bash", "cd", "git", "pip", "python"}

_BLOCK = re.compile(r"^```(\w+)(?: title=\"(.+?)\")?\n(.*?)^```", re.M | re.S)


@dataclass(frozen=True)
class Block:
    """A fenced block of a document."""

    document: Path
    language: str
    title: str
    text: str

    def __str__(self) -> str:
        first = self.text.strip().partition("\n")[0]
        return f"{self.document.relative_to(ROOT)}: {first}"


BLOCKS = [
    Block(document, *found)
    for document in DOCUMENTS
    for found in _BLOCK.findall(document.read_text())
]

HELP = ROOT / "remosplat_drake/commands/main.py"
BLOCKS += [
    Block(HELP, "sh", "", example)
    for examples in (
        *(group.example for group in GROUPS),
        *(load_command(command).EXAMPLES for command in COMMANDS),
    )
    for example in examples.strip().splitlines()
]
"""The examples of `remosplat --help` and of each command's."""


def blocks(language: str) -> list[Block]:
    """Different blocks of a language: what is repeated is tested once."""
    found = {b.text: b for b in reversed(BLOCKS) if b.language == language}
    return list(reversed(found.values()))


def command_lines(block: Block) -> list[list[str]]:
    lines = block.text.replace("\\\n", " ").splitlines()
    words = [shlex.split(line, comments=True) for line in lines]
    return [line for line in words if line]


def is_scenarios(block: Block) -> bool:
    """Whether it is a scenario file: names begin with capitals."""
    names = re.findall(r"^(\w+):", block.text, re.M)
    return bool(names) and all(name[0].isupper() for name in names)


SCENARIOS = [block for block in blocks("yaml") if is_scenarios(block)]


@pytest.fixture(scope="module")
def a_capture(rendering, tmp_path_factory) -> Path:
    """What the reader has taken of a table."""
    folder = tmp_path_factory.mktemp("a") / "capture"
    scene = str(models_dir() / "scenes/table/scene.json")
    shorter = SHORTER["render-capture"]
    assert (
        main(["render-capture", scene, str(folder), "--floor", *shorter]) == 0
    )
    return folder


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    """Where the reader stands, with the files that documents mention."""
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
    table = models_dir() / "scenes/table/splat.ply"
    (tmp_path / "scan.ply").symlink_to(table)
    (tmp_path / "script.yaml").write_text("steps: [{press: home}]\n")
    # A robot's maker has a library; no test has the robot.
    (tmp_path / "vendor.py").write_text("class Arm: ...\n")
    shutil.copy(ROOT / "tests/data/three_link.urdf", tmp_path / "my_arm.urdf")
    shutil.copy(models_dir() / "scenes/table/scene.json", tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def write_files(document: Path, folder: Path) -> list[str]:
    """Writes the files that a document shows; the modules among them."""
    files = [b for b in BLOCKS if b.document == document and b.title]
    for block in files:
        (folder / block.title).write_text(block.text)
    return [b.title.removesuffix(".py") for b in files if ".py" in b.title]


def carry_out(
    arguments: list[str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs one command line of ours, shortened, or at least parses it."""
    command = arguments[0]
    assert command in COMMANDS
    # There is no robot at hand.
    if command not in SHORTER or "--hardware" in arguments:
        monkeypatch.setattr(load_command(command), "run", lambda arguments: 0)
        assert main(arguments) == 0
        for name, value in pairwise(arguments):
            if name == "--lcm-url":
                check_lcm_url(value)
            elif name == "--scenario-text":
                load_scenario(override=value)
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
        arguments += ["--session", str(len(list(folder.iterdir())))]
    # The moment does not suffice to reach anything.
    assert main(arguments) == (1 if command == "run" else 0)


@pytest.mark.parametrize("block", blocks("sh"), ids=str)
def test_every_command_works(folder, block, request, monkeypatch):
    write_files(block.document, folder)
    if "my_capture" in block.text:
        capture = request.getfixturevalue("a_capture")
        shutil.copytree(capture, folder / "my_capture")
    targets = set(
        re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.M)
    )
    for program, *arguments in command_lines(block):
        if program == "make":
            assert arguments[0] in targets
        elif program == "remosplat":
            carry_out(arguments, folder, monkeypatch)
        else:
            assert program in FOREIGN, f"no test runs {program!r}"


def test_the_main_job_is_among_the_commands():
    lines = [line for block in blocks("sh") for line in command_lines(block)]
    assert ["make", "run"] in lines
    assert any(line[:2] == ["remosplat", "run"] for line in lines)


@pytest.mark.parametrize("block", SCENARIOS, ids=str)
def test_every_scenario_loads(folder, block):
    write_files(block.document, folder)
    file = folder / "example.yaml"
    file.write_text(block.text)
    for name in re.findall(r"^(\w+):", block.text, re.M):
        load_world(load_scenario(f"{file}:{name}"))


@pytest.mark.parametrize(
    "document",
    dict.fromkeys(b.document for b in blocks("python")),
    ids=lambda document: str(document.relative_to(ROOT)),
)
def test_all_python_runs(folder, document):
    """Blocks without a title are one program, from top to bottom."""
    modules = write_files(document, folder)
    program = [
        block
        for block in BLOCKS
        if (block.document, block.language) == (document, "python")
        and not block.title
    ]
    assert program or not modules, "nothing uses these modules"
    names = {"__name__": "example"}
    try:
        for block in program:
            exec(compile(block.text, str(block), "exec"), names)
    finally:
        for module in modules:
            sys.modules.pop(module, None)


@pytest.mark.parametrize("block", [b for b in BLOCKS if b.title], ids=str)
def test_every_file_is_used(block):
    """A scenario is loaded by a test; every other file by a block."""
    stem = Path(block.title).stem
    others = [b for b in BLOCKS if b.document == block.document]
    assert is_scenarios(block) or any(
        stem in other.text for other in others if other != block
    )


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda d: d.name)
def test_every_tag_is_one_of_a_scenario(document):
    for tag in set(re.findall(r"!([A-Z]\w+)", document.read_text())):
        field, content = "oracle", "{}"
        if tag.endswith("Station"):
            field = "station"
        elif tag == "CameraConfig":
            field, content = "wrist_camera", "{X_PB: {base_frame: camera}}"
        elif tag in ("KnownMovers", "StandingMovers", "UnknownMovers"):
            field = "mover_sensing"
        elif tag in DRIVERS:
            field, content = DRIVERS[tag]
            text = f"{{hardware: {{{field}: !{tag} {content}}}}}"
            hardware = load_scenario(override=text).hardware
            assert type(getattr(hardware, field)).__name__ == tag
            continue
        elif tag in MOVERS:
            scenario = load_scenario(override=f"{{movers: [!{tag} {{}}]}}")
            assert [type(m).__name__ for m in scenario.movers] == [tag]
            continue
        elif tag in STEPS:
            scenario = load_scenario(override=f"{{tasks: [!{tag} {{}}]}}")
            assert [type(step).__name__ for step in scenario.tasks] == [tag]
            continue
        text = f"{{{field}: !{tag} {content}}}"
        scenario = load_scenario(override=text)
        assert type(getattr(scenario, field)).__name__ == tag


DRIVERS = {
    "UrArm": ("arm_driver", "{host: 192.168.56.101}"),
    "Ros2Arm": ("arm_driver", "{}"),
    "Ros1Base": ("base_driver", "{}"),
    "Ros2Base": ("base_driver", "{}"),
    "Ros2Hand": ("hand_driver", "{}"),
}
"""Tags of drivers: their field of `hardware`, and what they need."""

STEPS = {step.__name__ for step in get_args(AnyStep)}
"""Tags of a task's steps."""

MOVERS = ("Person", "SwingingDoor", "RecordedMovers", "OtherRobot")
"""Tags of things that move."""


def without_blocks(text: str) -> str:
    """A document's text without its fenced blocks."""
    return re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)


@cache
def anchors(page: Path) -> set[str]:
    """By what a page's headings are linked, as MkDocs names them."""
    text = GENERATED[page]() if page in GENERATED else page.read_text()
    names: Counter[str] = Counter()
    found = set()
    for heading in re.findall(r"^#+ (.+)$", without_blocks(text), re.M):
        given = re.search(r"\{ *#(\S+) *\}$", heading)
        words = re.sub(r"[^\w\s-]", "", heading).strip().lower()
        name = given[1] if given else re.sub(r"[-\s]+", "-", words)
        found.add(f"{name}_{names[name]}" if names[name] else name)
        names[name] += 1
    return found


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda d: d.name)
def test_every_relative_link_leads_somewhere(document):
    links = re.findall(r"\]\(([^)\s]+)", without_blocks(document.read_text()))
    missing = []
    for link in links:
        path, _, anchor = link.partition("#")
        page = (document.parent / path).resolve() if path else document
        if "://" not in link and not (
            (page.exists() or page in GENERATED)
            and (not anchor or anchor in anchors(page))
        ):
            missing.append(link)
    assert missing == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda d: d.name)
def test_every_footnote_is_used_and_written(document):
    text = without_blocks(document.read_text())
    written = re.findall(r"^\[\^([^\]]+)\]:", text, re.M)
    assert set(re.findall(r"\[\^([^\]]+)\](?!:)", text)) == set(written)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda d: d.name)
def test_no_paragraph_stands_twice(document):
    paragraphs = without_blocks(document.read_text()).split("\n\n")
    counts = Counter(p for p in paragraphs if len(p.split()) > 8)
    assert [p for p, count in counts.items() if count > 1] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda d: d.name)
def test_every_path_and_module_exists(document):
    text = document.read_text()
    paths = re.findall(r"`([\w.-]+(?:/[\w.-]+)*/(?:[\w-]+\.\w+)?)`", text)
    modules = re.findall(r"python -m (apps[\w.]+\w)", text)
    modules += re.findall(r"`(remosplat_drake\.[\w.]+)`", text)
    paths += [
        module.replace(".", "/")
        for module in modules
        if not module.endswith(".NAME")
    ]
    places = ROOT, ROOT / "remosplat_drake"
    missing = [
        path
        for path in paths
        if path.startswith(OURS)
        and not any(list(p.glob(f"{path.rstrip('/')}*")) for p in places)
    ]
    assert missing == []


OURS = (
    "apps/",
    "controller/",
    "docs/",
    "models/",
    "remosplat_drake/",
    "scenarios/",
    "tests/",
)
"""How paths of the repository begin."""

GENERATED = {
    ROOT / "docs/reference/api.md": lambda: "",
    ROOT / "docs/reference/commands.md": reference_of_commands,
    ROOT / "docs/reference/scenario.md": lambda: reference_of(Scenario),
}
"""Pages that exist only in the built site, and what is known of their text."""


def test_the_readme_is_short():
    text = without_blocks(DOCUMENTS[0].read_text())
    text = re.sub(r"<!--.*?-->", "", text)
    assert len(text.split()) <= 1000
