"""Loads the methods of a comparison: controllers and their settings."""

import dataclasses as dc
import hashlib
from collections.abc import Sequence
from pathlib import Path

from remosplat_drake.app.map_knowledge import find_map_error, map_error_gates
from remosplat_drake.app.scenario import (
    YAML_SUFFIXES,
    Scenario,
    check_scenario,
    split_spec,
)
from remosplat_drake.app.scenario_robot import (
    load_scenario_robot,
    robot_file,
)
from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.extensions import extension_name, extensions_in
from remosplat_drake.base.strict_yaml import entries, load_strict
from remosplat_drake.benchmark.custom_controller import (
    load_controller,
    source_digest,
)
from remosplat_drake.oracle.oracle_config import GroundTruth
from remosplat_drake.safety.gates import open_gates
from remosplat_drake.station.station_config import KinematicStation

METHODS_FILE = Path(__file__).with_suffix(".yaml")
"""YAML file of the shipped methods."""

SHIPPED_CONTROLLERS = {
    "drake-ik": "remosplat_drake.benchmark.drake_baseline:make_control",
}
"""Short names for controllers of other projects that this package has
adapted."""

BASE_METHOD = "sdf-hard"
"""Method whose oracle, control period and time limit a custom controller has by
default."""

CONTROL_PERIOD = 0.05
"""Control period of the paper's benchmark (20 Hz) [s]."""

GROUPS = {
    "paper": (
        "sdf-hard",
        "sdf-active",
        "ellipsoid-hard",
        "ellipsoid-active",
        "depth-hard",
        "depth-active",
    ),
    "ours": (
        "sdf-guided",
        "sdf-guided-10mm",
        "ellipsoid-guided",
        "depth-guided",
    ),
    "moving": (
        "movers-known",
        "movers-seen",
        "movers-standing",
        "movers-unknown",
    ),
    "mbm": ("sdf-reactive-mbm", "sdf-guided-tuned-mbm", "sdf-guided-mbm"),
    "variants": (
        "sdf-hard-rows",
        "sdf-active-rows",
        "ellipsoid-hard-3-steps",
        "ellipsoid-active-3-steps",
        "ellipsoid-active-any-opacity",
    ),
}
"""Names that stand for groups of methods."""


@dc.dataclass(frozen=True)
class Method:
    """One controller of a comparison.

    Attributes:
        name: Name of the method in tables.
        scenario: The method's settings: a scenario without its scene.
        controller: Custom controller as MODULE:FUNCTION; empty for the
            package's reactive controller.
    """

    name: str
    scenario: Scenario
    controller: str = ""

    @property
    def needs_splat(self) -> bool:
        """Whether the method's oracle measures distances to a splat."""
        return not isinstance(self.scenario.oracle, GroundTruth)

    @property
    def gains(self) -> str:
        """Name of the gain set; "own" for a custom controller."""
        return "own" if self.controller else self.scenario.controller.gains

    @property
    def fingerprint(self) -> str:
        """Digest of all settings; it does not depend on their file."""
        settings = repr(dc.replace(self.scenario, source=""))
        for extension in extensions_in(self.scenario):
            name = extension_name(type(extension))
            settings += name + source_digest(name)
        if self.controller:
            settings += self.controller + source_digest(self.controller)
        return hashlib.sha256(settings.encode()).hexdigest()[:16]


def load_methods(
    names: Sequence[str],
    override: str = "",
    spheres: str | None = None,
    robot: str = "",
) -> list[Method]:
    """Loads methods by name, each once, in the given order.

    Args:
        names: Shipped names, names of `GROUPS` or `SHIPPED_CONTROLLERS`,
            FILE for all methods of a file, FILE:NAME for one of them, or a
            custom controller as MODULE:FUNCTION or MODULE:FUNCTION:METHOD.
        override: YAML that overrides fields of every method, e.g.
            "{time_limit: 5}".
        spheres: Name of the sphere set that every method uses; None keeps each
            method's sphere set.
        robot: Name or file of the robot that every method drives; empty keeps
            each method's robot.

    Raises:
        RemoSplatError: No method has such a name, or a file cannot be used.
    """
    found: dict[str, Method] = {}
    robots: set[tuple] = set()
    for name in names:
        controller, name = _split_controller(name)
        for path, entry in _find(name):
            scenario = _load(path, entry, override)
            if spheres is not None:
                scenario.robot.spheres = spheres
            if robot:
                scenario.robot.model = robot
            _check_robot(scenario, robots)
            method = Method(entry, scenario)
            if controller:
                method = _with_controller(method, controller)
            earlier = found.setdefault(method.name, method)
            if earlier.fingerprint != method.fingerprint:
                raise RemoSplatError(
                    "--methods: two different methods have the name "
                    f"{method.name!r}"
                )
    return list(found.values())


def _split_controller(name: str) -> tuple[str, str]:
    """Splits a name into the user's controller (or "") and a method's name."""
    first, *rest = name.split(":")
    name = ":".join([SHIPPED_CONTROLLERS.get(first, first), *rest])
    module, *rest = name.split(":")
    if not rest or Path(module).suffix in YAML_SUFFIXES:
        return "", name
    function, *base = rest
    return f"{module}:{function}", ":".join(base) or BASE_METHOD


def _with_controller(method: Method, controller: str) -> Method:
    load_controller(controller)
    if not isinstance(method.scenario.station, KinematicStation):
        raise RemoSplatError(
            f"--methods: {controller}: a custom controller runs only on the "
            "kinematic station; name a method with that station"
        )
    aliases = {path: alias for alias, path in SHIPPED_CONTROLLERS.items()}
    name = aliases.get(controller, controller)
    if method.name != BASE_METHOD:
        name += f":{method.name}"
    return Method(name, method.scenario, controller)


def _find(name: str) -> list[tuple[Path, str]]:
    found = split_spec(name)
    if found is not None:
        path, entry = Path(found[0]), found[1]
        names = [entry] if entry else entries(path)
    else:
        path, names = METHODS_FILE, list(GROUPS.get(name, [name]))
    valid = entries(path)
    for wanted in names:
        if wanted not in valid:
            # Names of groups are valid only for the file of shipped methods.
            groups = GROUPS if path == METHODS_FILE else ()
            others = (*groups, *SHIPPED_CONTROLLERS) if groups else ()
            problem = unknown_name("method", wanted, [*valid, *others])
            raise RemoSplatError(f"--methods: {problem}")
    return [(path, wanted) for wanted in names]


def _load(path: Path, entry: str, override: str) -> Scenario:
    defaults = Scenario(control_period=CONTROL_PERIOD)
    scenario = load_strict(Scenario, path, entry, override, defaults)
    where = scenario.source = f"{path}:{entry}"
    for field, given in (
        ("scene.splat", scenario.scene.splat),
        ("scene.truth", scenario.scene.truth),
        ("scene.directives", scenario.scene.directives),
        ("targets", scenario.targets),
    ):
        if given:
            raise FieldError(
                where, field, ("must be absent, since the benchmark sets it")
            )
    check_scenario(scenario)
    # A measured map error is required only for stopping distances below the
    # usual value. The benchmark's maps do not have a measured error.
    errors = map_error_gates(scenario, find_map_error(scenario))
    open_gates(errors, (), hardware=False, where=where)
    return scenario


def _check_robot(scenario: Scenario, loaded: set[tuple]) -> None:
    """Raises an error, before any trial, if the robot cannot be loaded.

    The function caches its result, since many methods have the same robot.
    """
    model, spheres = robot_file(scenario), scenario.robot.spheres
    robot = model, spheres, scenario.scene.floor_height
    if robot not in loaded:
        load_scenario_robot(scenario)
        loaded.add(robot)
