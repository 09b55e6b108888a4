"""The tree is the theory: allowed imports, read off the sources."""

import ast
import graphlib
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from sources import PACKAGE, modules, parsed

NAME = "remosplat_drake"

ARCHITECTURE = PACKAGE.parent / "docs" / "architecture.md"

HEAVY = {"torch", "gsplat", "open3d", "pyrealsense2"}
"""Optional packages that are imported inside functions."""

OPTIONAL = HEAVY | {
    "pytorch_msssim",
    "skimage",
    "trimesh",
    "rtbdata",
    "matplotlib",
    "PIL",
    "zstandard",
    "cyclonedds",
    "panda_py",
    "ruckig",
    "proxsuite",
    "daqp",
    "rtree",
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


@cache
def own_imports(path: Path) -> set[str]:
    """What a file imports from this package, without the package's name."""
    return {
        name.removeprefix(f"{NAME}.")
        for name in imports(parsed(path))
        if name.startswith(f"{NAME}.")
    }


@cache
def rooms() -> dict[str, set[str] | None]:
    """The rooms of the architecture page, from the ground up, and their use.

    None stands for "everything above".
    """
    rows = re.findall(
        r"^\| `(\w+)` \| .* \| (.*)\|$", ARCHITECTURE.read_text(), re.M
    )
    return {
        room: None
        if uses.strip() == "everything above"
        else set(re.findall(r"`(\w+)`", uses))
        for room, uses in rows
    }


def rooms_used_by(room: str) -> dict[str, Path]:
    """The rooms that a room imports, each with a file that does."""
    used = {
        name.split(".")[0]: path.relative_to(PACKAGE)
        for path in (PACKAGE / room).rglob("*.py")
        for name in own_imports(path)
    }
    used.pop(room, None)
    return used


def is_within(name: str, module: str) -> bool:
    return name == module or name.startswith(f"{module}.")


def test_every_folder_is_a_room_and_nothing_lies_beside_them():
    folders = {path.parent.name for path in PACKAGE.glob("*/__init__.py")}
    assert folders == rooms().keys()
    assert [path.name for path in PACKAGE.glob("*.py")] == ["__init__.py"]


@pytest.mark.parametrize("room", rooms())
def test_a_room_imports_what_the_architecture_page_says(room):
    names = list(rooms())
    above = set(names[: names.index(room)])
    used, declared = rooms_used_by(room), rooms()[room]
    if declared is None:
        assert used.keys() <= above, used
    else:
        assert used.keys() == declared, used
        assert declared <= above


def test_no_file_imports_itself_by_a_detour():
    """No circles, neither between rooms nor within one."""
    graph = {}
    for path in PACKAGE.rglob("*.py"):
        module = ".".join(path.relative_to(PACKAGE).with_suffix("").parts)
        graph[module] = own_imports(path)
    graph = {
        module: {
            name if name in graph else name.rpartition(".")[0] for name in names
        }
        for module, names in graph.items()
    }
    sorter = graphlib.TopologicalSorter(graph)
    sorter.prepare()


@pytest.mark.parametrize("room", rooms())
def test_folders_of_a_room_import_each_other_in_one_direction(room):
    """In the controller's, none imports the files that lie beside them."""
    folders = {path.parent.name for path in (PACKAGE / room).glob("*/*.py")}
    sorter = graphlib.TopologicalSorter()
    for folder in folders:
        for path in (PACKAGE / room / folder).rglob("*.py"):
            names = (name.split(".") for name in own_imports(path))
            used = {name[1] for name in names if name[0] == room}
            if room == "controller":
                assert used <= folders, path
            sorter.add(folder, *(used & folders - {folder}))
    sorter.prepare()


def test_only_the_application_wires_controller_and_station():
    for path in PACKAGE.rglob("*.py"):
        if "app" in path.relative_to(PACKAGE).parts:
            continue
        systems = {
            module
            for module in ("controller.reactive_controller", "station")
            for name in own_imports(path)
            if is_within(name, module) and "_config" not in name
        }
        assert len(systems) < 2, path


def test_optional_packages_are_imported_only_where_they_are_used():
    """Inside functions; training a splat needs torch as a whole."""
    for path in PACKAGE.rglob("*.py"):
        if "training" in path.parts:
            continue
        top = ast.Module(body=[], type_ignores=[])
        top.body = [
            node
            for node in parsed(path).body
            if isinstance(node, (ast.Import, ast.ImportFrom))
        ]
        wrong = {n for n in imports(top) if n.split(".")[0] in HEAVY}
        assert not wrong, f"{path.relative_to(PACKAGE)} imports {wrong}"


def test_one_file_makes_kernels():
    """Another one could do so before they are kept by their sources."""
    makers = re.compile(r"\b(jit|njit|vectorize|guvectorize|cfunc|stencil)\b")
    files = [p for p in PACKAGE.rglob("*.py") if makers.search(p.read_text())]
    assert files == [PACKAGE / "base" / "kernels" / "kernel.py"]


def test_pydrake_is_imported_from_its_modules():
    """`pydrake.all` takes a second to import."""
    for path, tree in modules().items():
        for name in imports(tree):
            assert not is_within(name, "pydrake.all"), path


@pytest.mark.parametrize("command", ["main", "run"])
def test_the_main_job_imports_no_optional_package(command):
    program = (
        f"import sys, {NAME}.commands.{command}; "
        f"print(*({OPTIONAL} & sys.modules.keys()))"
    )
    assert output_of(program) == ""


def test_a_run_waits_for_nothing_that_it_may_not_need():
    """Scipy's parts take half a second; what makes maps another quarter."""
    kept_out = [
        "scipy.linalg",
        "scipy.spatial",
        f"{NAME}.mapping.live_map",
        f"{NAME}.reconstruction.pipeline",
        f"{NAME}.cockpit.cockpit_process",
        f"{NAME}.detection.detection_state",
    ]
    program = (
        f"import sys, {NAME}.commands.run; "
        f"print(*(set({kept_out}) & sys.modules.keys()))"
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
