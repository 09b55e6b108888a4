"""The controllers that are compared: named scenarios without a scene."""

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
from remosplat_drake.base.errors import FieldError, RemoSplatError, unknown_name
from remosplat_drake.base.extensions import extension_name, extensions_in
from remosplat_drake.base.strict_yaml import entries, load_strict
from remosplat_drake.benchmark.custom_controller import (
    load_controller,
    source_digest,
)
from remosplat_drake.oracle.oracle_config import GroundTruth
from remosplat_drake.robot.robot_model import load_robot
from remosplat_drake.safety.gates import open_gates
from remosplat_drake.station.station_config import KinematicStation

METHODS_FILE = Path(__file__).with_suffix(".yaml")
"""The shipped methods."""

SHIPPED_CONTROLLERS = {
    "drake-ik": "remosplat_drake.benchmark.drake_baseline:make_control",
}
"""Short names for controllers that are not ours but come with the package."""

BASE_METHOD = "sdf-hard"
"""Whose oracle, period and limits one's own controller gets by default."""

CONTROL_PERIOD = 0.05
"""The paper's benchmark runs at 20 Hz [s]."""

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
    "variants": (
        "sdf-hard-rows",
        "sdf-active-rows",
        "ellipsoid-hard-3-steps",
        "ellipsoid-active-3-steps",
        "ellipsoid-active-any-opacity",
    ),
}
"""Short names for several methods."""


@dc.dataclass(frozen=True)
class Method:
    """One controller of a comparison.

    Attributes:
        name: As tables show it.
        scenario: Everything but the scene.
        controller: One's own, as MODULE:FUNCTION; empty for ours.
    """

    name: str
    scenario: Scenario
    controller: str = ""

    @property
    def needs_splat(self) -> bool:
        """Whether its oracle looks at a splat."""
        return not isinstance(self.scenario.oracle, GroundTruth)

    @property
    def gains(self) -> str:
        """The gain set; what one's own does has nothing to do with ours."""
        return "own" if self.controller else self.scenario.controller.gains

    @property
    def fingerprint(self) -> str:
        """A digest of all settings, whatever file they came from."""
        settings = repr(dc.replace(self.scenario, source=""))
        for extension in extensions_in(self.scenario):
            name = extension_name(type(extension))
            settings += name + source_digest(name)
        if self.controller:
            settings += self.controller + source_digest(self.controller)
        return hashlib.sha256(settings.encode()).hexdigest()[:16]


def load_methods(
    names: Sequence[str], override: str = "", spheres: str | None = None
) -> list[Method]:
    """Methods by name, in the order given, each once.

    Args:
        names: Shipped names, names of `GROUPS` or `SHIPPED_CONTROLLERS`,
            FILE for all methods of one's own file, FILE:NAME, or one's own
            controller as MODULE:FUNCTION or MODULE:FUNCTION:METHOD.
        override: YAML laid over every method, e.g. "{time_limit: 5}".
        spheres: Sphere set for every method, in place of its own.

    Raises:
        RemoSplatError: Nothing of that name, or a file cannot be used.
    """
    found: dict[str, Method] = {}
    for name in names:
        controller, name = _split_controller(name)
        for path, entry in _find(name):
            scenario = _load(path, entry, override)
            if spheres is not None:
                scenario.robot.spheres = spheres
            _check_robot(scenario)
            method = Method(entry, scenario)
            if controller:
                method = _with_controller(method, controller)
            earlier = found.setdefault(method.name, method)
            if earlier.fingerprint != method.fingerprint:
                raise RemoSplatError(
                    "--methods: two different methods are called"
                    f" {method.name!r}"
                )
    return list(found.values())


def _split_controller(name: str) -> tuple[str, str]:
    """One's own controller, if any, and the method whose settings it uses."""
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
            f"--methods: {controller}: needs the kinematic station"
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
            # Groups are only known for the shipped file.
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
            raise FieldError(where, field, "is the benchmark's to choose")
    check_scenario(scenario)
    # The benchmark drives in maps that nobody has measured; only distances
    # below the usual one need to know.
    errors = map_error_gates(scenario, find_map_error(scenario))
    open_gates(errors, (), hardware=False, where=where)
    return scenario


def _check_robot(scenario: Scenario) -> None:
    """Finds out before anything runs whether the robot is there."""
    load_robot(scenario.robot.model, scenario.robot.spheres)
