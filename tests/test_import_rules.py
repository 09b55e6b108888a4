"""The tree is the theory: who may import whom, read off the sources."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import remosplat_drake

PACKAGE = Path(remosplat_drake.__file__).parent
NAME = "remosplat_drake"

EVERYONE = {
    "errors",
    "resources",
    "atomic_file",
    "ranges",
    "reading",
    "strict_json",
    "strict_yaml",
    "yaml_nodes",
    "colors",
    "one_thread",
    "system_libraries",
}
"""Small modules at the bottom that anybody may use."""

ALLOWED = {
    "scene": set(),
    "splat": set(),
    "robot": set(),
    "oracle": {"scene", "splat", "robot"},
    # A supervisor reads what the controller and the station report.
    "safety": {
        "controller.tick_report",
        "oracle",
        "robot",
        "station.status",
    },
    "controller": {"oracle", "robot", "safety"},
    "messages": set(),
    "station": {"messages", "robot", "scene"},
    # A camera gives posed frames.
    "drivers": {"capture", "messages", "robot", "scene", "station"},
    "task": {"controller.servo", "oracle", "robot"},
    # Stands in the place of a target sequence; a scan wants frames.
    "teleop": {
        "capture.camera_mount",
        "controller.servo",
        "controller.tick_report",
        "mapping.map_requests",
        "messages",
        "robot",
        "safety.supervision",
        "scene.primitive_scene",
        "station.hardware.config",
        "task.target_sequence",
    },
    # The log holds the supervisor's mode; figures are made of it later.
    "recording": {
        "controller.tick_report",
        "oracle",
        "robot",
        "safety.supervision",
        "teleop.deviation",
    },
    # A live camera needs the names of the station's ports: inert data.
    "capture": {
        "oracle",
        "robot",
        "scene",
        "station.config",
        "station.ports",
    },
    "reconstruction": {"capture", "oracle", "robot", "scene", "splat"},
    "mapping": {
        "capture",
        "oracle",
        "reconstruction",
        "robot",
        "scene",
        "splat",
    },
    "visualization": {
        "controller.guidance",
        "controller.ingredients.collision_damper",
        "controller.servo",
        "controller.tick_report",
        "mapping.map_requests",
        "mapping.map_status",
        "mapping.scene_map",
        "oracle",
        "recording.run_log",
        "robot",
        "safety.operator",
        "safety.supervision",
        "scene",
        "splat",
        "station.status",
        "reconstruction.coverage",
        "teleop.config",
        "teleop.deviation",
        "teleop.operator_command",
        "teleop.target_state",
        "teleop.gamepad",
    },
}
"""The stages of the data flow; what a stage may import besides itself."""

ABOVE_THE_STAGES = {
    "benchmark",
    "commands",
    "control_loop",
    "diagram",
    "hardware_limits",
    "hardware_run",
    "recorded_run",
    "simulation",
    "stages",
    "teleop_session",
    "teleop_stages",
    "warm_up",
}
"""These see the wired application, and no stage may see them."""

HEAVY = {"torch", "gsplat", "open3d", "pyrealsense2"}
"""Optional packages that are imported inside functions."""

OPTIONAL = HEAVY | {
    "trimesh",
    "rtbdata",
    "matplotlib",
    "PIL",
    "zstandard",
    "cyclonedds",
    "panda_py",
}
"""All that a default installation does without."""


def imports(tree: ast.AST) -> Iterator[str]:
    """Dotted names of all modules that a source file imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, "imports are absolute"
            assert node.module
            # `from package import module` names a module as well.
            yield from (f"{node.module}.{a.name}" for a in node.names)


def sources(stage: str) -> list[Path]:
    folder = PACKAGE / stage
    return sorted(folder.rglob("*.py")) or [PACKAGE / f"{stage}.py"]


def own_imports(path: Path) -> set[str]:
    """What a file imports from this package, without the package's name."""
    return {
        name.removeprefix(f"{NAME}.")
        for name in imports(ast.parse(path.read_text()))
        if name.startswith(f"{NAME}.")
    }


def is_within(name: str, allowed: set[str]) -> bool:
    return any(name == a or name.startswith(f"{a}.") for a in allowed)


def is_within_any(path: Path, modules: set[str]) -> bool:
    return any(is_within(name, modules) for name in own_imports(path))


def test_every_package_has_a_rule():
    packages = {p.parent.name for p in PACKAGE.glob("*/__init__.py")}
    assert packages <= ALLOWED.keys() | ABOVE_THE_STAGES


@pytest.mark.parametrize("stage", ALLOWED)
def test_a_stage_imports_only_what_is_below_it(stage):
    allowed = ALLOWED[stage] | EVERYONE | {stage}
    for path in sources(stage):
        wrong = {n for n in own_imports(path) if not is_within(n, allowed)}
        assert not wrong, f"{path.relative_to(PACKAGE)} imports {wrong}"


def test_what_everyone_uses_uses_nobody_else():
    for module in EVERYONE:
        for path in sources(module):
            wrong = {n for n in own_imports(path) if not is_within(n, EVERYONE)}
            assert not wrong, f"{module} imports {wrong}"


def test_only_what_is_above_the_diagram_imports_it():
    for path in PACKAGE.rglob("*.py"):
        stage = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if stage not in ABOVE_THE_STAGES:
            assert not is_within_any(path, ABOVE_THE_STAGES), path


def test_only_the_diagram_wires_controller_and_station():
    """A scenario knows their configurations; nobody else knows both."""
    for path in PACKAGE.rglob("*.py"):
        if path.name in ("control_loop.py", "diagram.py", "stages.py"):
            continue
        systems = {n for n in own_imports(path) if ".config" not in n}
        both = [
            any(is_within(n, {stage}) for n in systems)
            for stage in ("controller.reactive_controller", "station")
        ]
        assert not all(both), path


def test_optional_packages_are_imported_only_where_they_are_used():
    """Inside functions; reconstruction needs torch as a whole."""
    for path in PACKAGE.rglob("*.py"):
        if path.parent.name == "reconstruction":
            continue
        top = ast.Module(body=[], type_ignores=[])
        top.body = [
            node
            for node in ast.parse(path.read_text()).body
            if isinstance(node, (ast.Import, ast.ImportFrom))
        ]
        wrong = {n for n in imports(top) if n.split(".")[0] in HEAVY}
        assert not wrong, f"{path.relative_to(PACKAGE)} imports {wrong}"


def test_pydrake_is_imported_from_its_modules():
    """`pydrake.all` takes a second to import."""
    for path in PACKAGE.rglob("*.py"):
        for name in imports(ast.parse(path.read_text())):
            assert not is_within(name, {"pydrake.all"}), path


@pytest.mark.parametrize("command", ["main", "run"])
def test_the_main_job_imports_no_optional_package(command):
    program = (
        f"import sys, {NAME}.commands.{command}; "
        f"print(*({OPTIONAL} & sys.modules.keys()))"
    )
    assert output_of(program) == ""


def test_finding_a_command_is_quick():
    """`remosplat --help` loads neither Drake nor numba."""
    program = (
        f"import sys, {NAME}.commands.main; "
        "print(*({'pydrake', 'numba', 'numpy'} & sys.modules.keys()))"
    )
    assert output_of(program) == ""


def output_of(program: str) -> str:
    """What a fresh interpreter prints."""
    answer = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=True,
    )
    return answer.stdout.strip()
