"""`remosplat import-robot`: prepares a robot from its URDF or other files."""

import argparse
import shutil
import tempfile
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console

from remosplat_drake.app.compiling import compiling_shown
from remosplat_drake.base.errors import FieldError, FileError, RemoSplatError
from remosplat_drake.base.progress import Progress
from remosplat_drake.base.system_libraries import (
    MissingLibraryError,
    import_optional,
)
from remosplat_drake.base.table import Table
from remosplat_drake.capture.rendering.robot_picture import draw_robot
from remosplat_drake.commands.first_scenario import (
    Tried,
    write_first_scenario,
)
from remosplat_drake.commands.tables import open_console, print_table
from remosplat_drake.robot.importing.findings import Findings
from remosplat_drake.robot.importing.joint_roles import side_names
from remosplat_drake.robot.importing.mobile_base import BASES
from remosplat_drake.robot.importing.packages import given_packages
from remosplat_drake.robot.importing.robot_import import (
    TOLERANCE,
    ImportRequest,
    import_robot,
)
from remosplat_drake.robot.robot_model import RobotModel

EXAMPLES = """
remosplat import-robot my_arm.urdf
remosplat import-robot my_arm.urdf --end-effector tool0 --out my_arm
remosplat import-robot my_arm.xml --base differential
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser):
    """Declares the command's flags."""
    parser.add_argument(
        "robot",
        type=Path,
        metavar="FILE",
        help="URDF, xacro, SDFormat, MuJoCo MJCF or Drake model directives",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="folder to create (default: the file's name, in the working"
        " directory)",
    )
    parser.add_argument(
        "--end-effector",
        action="append",
        default=[],
        metavar="[NAME=]LINK",
        help=(
            "link whose frame the controller moves to targets; repeat the "
            "flag for several arms (default: read from the SRDF, or guessed "
            "for one or two arms)"
        ),
    )
    parser.add_argument(
        "--base",
        choices=BASES,
        help="kind of base (default: differential if it has wheels, else"
        " fixed)",
    )
    parser.add_argument(
        "--package",
        action="append",
        default=[],
        metavar="NAME=DIR",
        help=(
            "folder of a ROS package. Folders above the file, and in "
            "ROS_PACKAGE_PATH, AMENT_PREFIX_PATH, COLCON_PREFIX_PATH, "
            "GZ_SIM_RESOURCE_PATH and GAZEBO_MODEL_PATH, are searched in any "
            "case"
        ),
    )
    parser.add_argument(
        "--srdf",
        type=Path,
        metavar="FILE",
        help="the robot's SRDF (default: one beside the file)",
    )
    parser.add_argument(
        "--arg",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="an argument for the xacro file",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e3 * TOLERANCE,
        metavar="MM",
        help=(
            "largest distance by which spheres may protrude from a link's "
            f"surface ({1e3 * TOLERANCE:g} mm)"
        ),
    )
    parser.add_argument(
        "--no-scenario",
        action="store_true",
        help="do not create a first scenario, and make no trial run",
    )


def run(args: argparse.Namespace) -> int:
    """Imports a robot into a new folder."""
    out = args.out or Path(args.robot.name.partition(".")[0])
    if out.exists():
        raise FileError(
            out, ("exists already; choose another folder with --out")
        )
    request = _request(args, out)
    console = open_console()
    findings = Findings()
    try:
        out.absolute().parent.mkdir(parents=True, exist_ok=True)
        made = tempfile.mkdtemp(dir=out.absolute().parent, prefix=".import-")
    except OSError as error:
        raise FileError(out, error.strerror or str(error)) from error
    folder = Path(made)
    try:
        folder.chmod(0o755)
        robot = _import(request, folder, findings, console)
        tried = None
        if not args.no_scenario:
            tried = _scenario(robot, folder, findings, console)
        _picture(robot, folder, findings)
        folder.rename(out)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    _report(console, out, robot, findings, tried)
    return 0


def _request(args: argparse.Namespace, out: Path) -> ImportRequest:
    if not 0.5 <= args.tolerance <= 200:
        problem = f"expected 0.5 to 200 [mm], got {args.tolerance:g}"
        raise FieldError("import-robot", "--tolerance", problem)
    arguments = {}
    for text in args.arg:
        name, equals, value = text.partition("=")
        if not (name and equals):
            raise FieldError("--arg", text, "expected NAME=VALUE")
        arguments[name] = value
    made_by = [f"remosplat import-robot {args.robot.name}"]
    if args.base:
        made_by.append(f"--base {args.base}")
    made_by += [f"--end-effector {text}" for text in args.end_effector]
    return ImportRequest(
        source=args.robot.expanduser(),
        packages=given_packages(args.package),
        base=args.base,
        end_effectors=_end_effectors(args.end_effector),
        srdf=args.srdf,
        arguments=arguments,
        tolerance=1e-3 * args.tolerance,
        made_by=" ".join(made_by),
    )


def _end_effectors(texts: list[str]) -> dict[str, str]:
    """Returns the links of the end effectors, keyed by the effector's name."""
    parts = [text.rpartition("=") for text in texts]
    links = [link for _, _, link in parts]
    if len(links) == 1:
        return {"": links[0]}
    names = [name for name, _, _ in parts]
    if not all(names):
        names = side_names(links)
    if len(set(names)) < len(names) or len(set(links)) < len(links):
        problem = f"names and links must be unique, got {texts}"
        raise FieldError("import-robot", "--end-effector", problem)
    return dict(zip(names, links, strict=True))


def _import(
    request: ImportRequest, folder: Path, findings: Findings, console: Console
) -> RobotModel:
    with Progress(console, "reading") as progress:
        return import_robot(request, folder, findings, progress.report)


def _scenario(
    robot: RobotModel, folder: Path, findings: Findings, console: Console
) -> Tried | None:
    what = "running a scenario"
    with Progress(console, what) as progress, compiling_shown(progress):
        on_try = partial(progress.report, what)
        try:
            return write_first_scenario(robot, folder, on_try)
        except RemoSplatError as error:
            for name in ("scenario.yaml", "scene.json", "scene.ply"):
                (folder / name).unlink(missing_ok=True)
            findings.guess("scenario", f"none: {error}")
            return None


def _picture(robot: RobotModel, folder: Path, findings: Findings) -> None:
    try:
        pictures = import_optional("PIL.Image", "pictures", "robots")
        picture = draw_robot(robot, np.array(robot.q_home))
    except (MissingLibraryError, RemoSplatError) as error:
        findings.guess("picture", f"none: {error}")
        return
    pictures.fromarray(picture).save(folder / "robot.png", optimize=True)


def _report(
    console: Console,
    out: Path,
    robot: RobotModel,
    findings: Findings,
    tried: Tried | None,
) -> None:
    """Prints one page of findings, guesses and next steps."""
    for title, pairs in (
        ("found", findings.found),
        (
            "guessed: check these values, and correct them in the description",
            findings.guessed,
        ),
        ("implausible: check these values", findings.doubted),
    ):
        if not pairs:
            continue
        print_table(console, Table(title, ("", ""), tuple(pairs), texts=2))
        console.print()
    name = robot.description.name
    lines = [f"wrote {out}/: {name}.yaml describes the robot"]
    if (out / "robot.png").is_file():
        lines.append(f"look at {out}/robot.png: the robot and its spheres")
    if tried is not None:
        lines += [
            f"trial run: {tried.reached} targets reached in {tried.time:.1f} "
            f"s, clearance {1e3 * tried.clearance:.0f} mm",
            f"next: `remosplat run {out}/scenario.yaml`",
        ]
    for line in lines:
        console.print(line, soft_wrap=True, highlight=False, markup=False)
