"""`remosplat run scene.ply`: generates a scenario for a splat."""

from pathlib import Path

import numpy as np
import yaml
from rich.console import Console

from remosplat_drake.app.map_knowledge import find_map_error
from remosplat_drake.app.scenario import (
    Scenario,
    check_scenario,
    load_scenario,
    shipped_scenarios,
    split_spec,
)
from remosplat_drake.app.scenario_robot import (
    load_scenario_robot,
    robot_beside,
    robot_file,
)
from remosplat_drake.app.scenario_text import scenario_text
from remosplat_drake.app.seen_space import seen_file
from remosplat_drake.app.world import load_splat
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError, RemoSplatError
from remosplat_drake.base.pose_config import make_transform
from remosplat_drake.base.resources import expand, resolve
from remosplat_drake.base.strict_yaml import load_text
from remosplat_drake.commands.suggested_entry import (
    as_yaml,
    scenario_path,
    suggested_entry,
)
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.reconstruction.seen_file import read_seen_space
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals.coverage import FREE
from remosplat_drake.splat.formats import FORMATS, format_of_file
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.task.suggestion import Suggestion, suggest_task

_BELOW, _MOST_BELOW = -0.1, 0.05
"""Gaussians below this height count as below the floor [m]. They count as noise
if they have at most this fraction of the splat's opacity."""

_OUTSIDE = 0.02
"""Fraction of the splats, at each end of an axis, that counts as outliers and
is ignored."""

_HINT = (
    "z must be up, z = 0 must be the floor, and the unit must be metres (use "
    "`remosplat convert --align floor --scale S` or --scenario-text "
    "'{scene: {X_WG: ..., scale: ...}}')"
)

_UNSEEN = (
    "the space that the cameras of this splat have seen is unknown, so all "
    "space without splats counts as free; `remosplat reconstruct` writes a "
    "file of the seen space beside a splat"
)


def load_given(
    spec: str | None,
    override: str,
    console: Console,
    save: Path | None = None,
    hardware: bool = False,
) -> Scenario:
    """Reads the scenario that a command line names, or makes one for a splat.

    Args:
        spec: NAME, FILE or FILE:NAME of a scenario, or a splat file.
        override: YAML that overrides the scenario.
        console: Console on which the chosen scenario is printed.
        save: File that receives a generated scenario.
        hardware: Whether a real robot will move; it needs an existing scenario.

    Raises:
        RemoSplatError: There is no such scenario, or no scenario can be
            generated.
    """
    splat = None if spec is None else _splat_of(spec)
    if splat is None:
        if save is not None:
            raise RemoSplatError(
                "--save-scenario: has an effect only for a splat file without "
                "a scenario; leave it out"
            )
        return load_scenario(spec, override)
    if hardware:
        raise RemoSplatError(
            "--hardware: a real robot needs a scenario file that you have "
            f"reviewed, not a splat: {splat}"
        )
    beside = scenario_path(splat)
    if save is None and _is_of(beside, splat):
        _say(console, f"no scenario given: {beside}, which is beside the splat")
        return load_scenario(str(beside), override)
    return _made_up(splat, override, console, save)


def _splat_of(spec: str) -> Path | None:
    """Returns the splat file that a command line names; None if none."""
    if split_spec(spec) is not None or spec in shipped_scenarios():
        return None
    path = expand(spec)
    if not path.exists():
        is_splat = path.name.lower().endswith(tuple(f.suffix for f in FORMATS))
        return resolve(spec) if is_splat else None
    try:
        format_of_file(path)
    except FileError as error:
        kind = "a folder, and " if path.is_dir() else ""
        raise FileError(
            path,
            f"is {kind}neither a scenario (.yaml, .yml) nor a splat"
            f" ({error.problem})",
        ) from error
    return path


def _is_of(scenario: Path, splat: Path) -> bool:
    """Whether the file's first scenario exists and uses this splat."""
    if not scenario.is_file():
        return False
    named = load_scenario(str(scenario))
    return (named.folder / named.scene.splat).resolve() == splat.resolve()


def _made_up(
    splat: Path, override: str, console: Console, save: Path | None
) -> Scenario:
    wanted = _laid_over(Scenario(), override, splat)
    if wanted.targets:
        return wanted
    robot = load_scenario_robot(wanted)
    try:
        task = _suggested(wanted, robot)
    except FileError:
        raise
    except RemoSplatError as error:
        raise FileError(
            splat, f"no scenario given, and none can be generated: {error}"
        ) from error
    error = find_map_error(wanted).largest
    folder = splat.parent if save is None else save.parent
    named = robot_beside(robot_file(wanted), folder)
    entry = suggested_entry(str(splat.resolve()), task, named, error)
    base = load_text(Scenario, yaml.safe_dump(entry), str(splat), Scenario())
    scenario = _laid_over(base, override, splat)
    keep = Path(splat.name).with_suffix(".yaml")
    keeps = f"`remosplat run {splat} --save-scenario {keep}` keeps it"
    if save is not None:
        if save.resolve().parent == splat.resolve().parent:
            entry["scene"]["splat"] = splat.name
        named = as_yaml(splat, entry)
        if override:
            named = scenario_text(scenario, splat.stem.capitalize())
        write_atomically(save, named)
        keeps = f"it is in {save}"
    _say(console, f"no scenario given: {_words(task, robot)}; {keeps}")
    if seen_file(scenario) is None:
        _say(console, _UNSEEN)
    return scenario


def _laid_over(base: Scenario, override: str, splat: Path) -> Scenario:
    """Returns a scenario for a splat, with the command line's overrides."""
    scenario = base
    if override:
        scenario = load_text(Scenario, override, "--scenario-text", base)
    scenario.scene.splat = scenario.scene.splat or str(splat.resolve())
    scenario.source = str(splat)
    check_scenario(scenario)
    return scenario


def _suggested(scenario: Scenario, robot: RobotModel) -> Suggestion:
    """Finds start and target in a splat; rejects a splat with a wrong pose."""
    splat_W, _ = load_splat(scenario)
    assert splat_W is not None
    if robot.n_base:
        _check_floor(splat_W)
    lower, upper = np.quantile(splat_W.p_GK, (_OUTSIDE, 1 - _OUTSIDE), axis=0)
    try:
        return suggest_task(
            robot,
            SphereToEllipsoidField(splat_W),
            lower,
            upper,
            _free_space(scenario),
            may_move_map=scenario.scene.X_WG == Scenario().scene.X_WG,
        )
    except RemoSplatError as error:
        raise RemoSplatError(f"{error}; {_HINT}") from error


def _check_floor(splat_W: GaussianSplat) -> None:
    """Rejects a splat of which a large part lies below the floor."""
    below = splat_W.opacities[splat_W.p_GK[:, 2] < _BELOW].sum()
    fraction = below / splat_W.opacities.sum()
    if fraction > _MOST_BELOW:
        raise RemoSplatError(
            f"{100 * fraction:.0f} % of the splat lies below the floor; {_HINT}"
        )


def _free_space(scenario: Scenario):
    """Returns a function that tells which points in W are known to be free.

    If the seen space is unknown, the function returns True for all points.
    Targets inside solids are excluded elsewhere, since no free path leads to
    them from the base.
    """
    path = seen_file(scenario)
    if path is None:
        return lambda p_W: np.ones(len(p_W), bool)
    coverage = read_seen_space(path, Path(scenario.scene.splat))
    X_GW = make_transform(
        scenario.scene.X_WG, scenario.source, "scene.X_WG"
    ).inverse()
    return lambda p_W: coverage.states_at(X_GW.multiply(p_W.T).T) == FREE


def _words(task: Suggestion, robot: RobotModel) -> str:
    """Describes the robot's start and its target."""
    x, y, z = task.X_WT.translation()
    start = "at the origin"
    if not task.X_WG.IsExactlyIdentity():
        start += ", after scene.X_WG has moved the splat"
    if task.base_pose is not None:
        start = "from x {:.2f}, y {:.2f} m".format(*task.base_pose)
    return (
        f"{robot.description.name} starts {start}, with a target at"
        f" ({x:.2f}, {y:.2f}, {z:.2f}) m"
    )


def _say(console: Console, line: str) -> None:
    console.print(line, soft_wrap=True, highlight=False, markup=False)
