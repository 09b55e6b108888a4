"""Imports a robot: converts its files to a description with spheres."""

import dataclasses as dc
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.robot.fitting.covering import fit_covering
from remosplat_drake.robot.fitting.model_surfaces import SurfaceOptions
from remosplat_drake.robot.importing.arm_choice import (
    ArmChoice,
    choose_arm,
)
from remosplat_drake.robot.importing.completion import (
    JointLimits,
    complete_inertias,
    complete_limits,
)
from remosplat_drake.robot.importing.description_text import description_text
from remosplat_drake.robot.importing.findings import Findings, listed
from remosplat_drake.robot.importing.ground import lowest_points
from remosplat_drake.robot.importing.home import guess_home, tightness
from remosplat_drake.robot.importing.joint_roles import has_wheels
from remosplat_drake.robot.importing.link_gaps import find_link_gaps
from remosplat_drake.robot.importing.link_pieces import fit_link_pieces
from remosplat_drake.robot.importing.link_shapes import convert_shapes
from remosplat_drake.robot.importing.missing_meshes import replace_missing
from remosplat_drake.robot.importing.mobile_base import (
    DIFFERENTIAL,
    DRIVES,
    FIXED,
    JOINTS,
    OMNI,
    add_base_joints,
    base_limits,
)
from remosplat_drake.robot.importing.overlaps import doubt_overlaps
from remosplat_drake.robot.importing.packages import Packages
from remosplat_drake.robot.importing.planar_base import without_planar_base
from remosplat_drake.robot.importing.sources import read_robot
from remosplat_drake.robot.importing.srdf import Srdf, find_srdf, read_srdf
from remosplat_drake.robot.importing.urdf import Urdf
from remosplat_drake.robot.importing.urdf_elements import transmission_element
from remosplat_drake.robot.importing.urdf_numbers import check_numbers
from remosplat_drake.robot.reach import arm_reach
from remosplat_drake.robot.robot_description import (
    Arm,
    MobileBase,
    RobotDescription,
)
from remosplat_drake.robot.robot_model import (
    ROUNDING,
    RobotModel,
    load_robot,
)

TOLERANCE = 0.02
"""Default distance by which spheres may protrude from links [m]."""

_HAND_WEIGHT = 2.0
"""Weight of links from the wrist outwards. It is large, since their spheres
should be tight."""

_STILL_WEIGHT = 0.5
"""Weight of links that do not move. It is small, since their spheres matter
only for self-collision with the arm."""

_ON_FLOOR = 0.1
"""A base's link is assumed to stand on the floor if its lowest point is less
than this above the robot's lowest point [m]."""

_SHORTEST, _LONGEST = 0.05, 10.0
"""Plausible range of an arm's reach [m]."""

_UNITS = (
    "check that all origins are right, all lengths are in m, and all meshes "
    "are scaled to m"
)
"""Possible errors in the files of a robot with implausible sizes."""

_OFF_LIMITS = 0.01
"""If a named state that becomes the home is at a joint limit, the home keeps
this distance from the limit [rad, m]."""

_LEFT_OUT = ("gazebo", "transmission", "ros2_control", "sensor")


@dc.dataclass(frozen=True)
class ImportRequest:
    """The inputs of an import.

    Attributes:
        source: The robot's file, in any format that `read_robot` reads.
        packages: Folders of ROS packages by name, which have precedence over
            folders that are found.
        base: One of `BASES`; None: guessed from the robot's wheels.
        end_effectors: Names of the end effectors' links, by the end effectors'
            names; empty: they are guessed.
        srdf: The robot's SRDF; None: the SRDF beside the source, if there is
            one.
        arguments: Arguments of a xacro by name.
        tolerance: Distance by which spheres may protrude from links [m].
        made_by: Command line, for comments in the files.
    """

    source: Path
    packages: dict[str, Path] = dc.field(default_factory=dict)
    base: str | None = None
    end_effectors: dict[str, str] = dc.field(default_factory=dict)
    srdf: Path | None = None
    arguments: dict[str, str] = dc.field(default_factory=dict)
    tolerance: float = TOLERANCE
    made_by: str = "remosplat import-robot"


def import_robot(
    request: ImportRequest,
    folder: Path,
    findings: Findings,
    on_progress: Callable[[str, int, int], None] = lambda what, i, n: None,
) -> RobotModel:
    """Writes a robot's model, meshes, spheres and description into a folder.

    Args:
        request: The request.
        folder: The folder, which exists and is empty.
        findings: Receives the values that were found and guessed.
        on_progress: Called with the name of the present step, the number of
            finished steps, and the number of all.

    Returns:
        The robot, as it is loaded from that folder.

    Raises:
        RemoSplatError: A file is missing or unusable; the text names file and
            element.
    """
    ours = {"remosplat_drake": resources.models_dir().parent}
    packages = Packages(request.source, ours | request.packages)
    urdf, said = read_robot(
        request.source, packages, request.arguments, findings
    )
    check_numbers(urdf)
    base = request.base
    if base in (None, OMNI):
        driven = without_planar_base(urdf, findings)
        urdf, base = (urdf, base) if driven is None else (driven, OMNI)
    findings.find(
        "model",
        f"{urdf.name}: {len(urdf.links)} links, {len(urdf.joints)} joints",
    )
    srdf = _srdf(request, urdf, said, findings)
    arm = choose_arm(urdf, srdf, request.end_effectors, findings)
    limits = complete_limits(urdf, arm.joints, findings)
    replace_missing(urdf, packages, findings)
    complete_inertias(urdf, findings)
    n_meshes = sum(1 for _ in urdf.root.iter("mesh"))
    done = 0

    def on_mesh() -> None:
        nonlocal done
        done += 1
        on_progress("converting meshes", done, n_meshes)

    meshes = convert_shapes(urdf, packages, folder, findings, on_mesh)
    for what, place in packages.guessed.items():
        findings.guess(what, f"is not at its stated place; used: {place}")
    base = base or _guessed_base(urdf, srdf, findings)
    description = _described(urdf, arm, limits, base, folder, findings)
    description = _with_allowed_collisions(description, srdf)
    fit_link_pieces(
        urdf, description, meshes, srdf.states, findings, on_progress
    )
    covering = fit_covering(
        description.model_path,
        _surface_options(urdf, arm, base),
        tolerance=request.tolerance,
        on_progress=on_progress,
    )
    comments = [f"{len(covering)} spheres, made by `{request.made_by}`."]
    write_atomically(folder / "spheres.yaml", covering.to_yaml(comments))
    worst = max(covering.bulges, key=lambda link: covering.bulges[link].max)
    findings.find(
        "spheres",
        f"{len(covering)}; those of {worst} extend farthest beyond their link,"
        f" by {1e3 * covering.bulges[worst].max:.0f} mm",
    )
    on_progress("looking for a home", 0, 1)
    path = Path(description.source)
    write_atomically(path, description_text(description, "", Findings()))
    robot = load_robot(path)
    _judge_sizes(urdf, robot, findings)
    description.home = _chosen_home(robot, srdf, findings)
    write_atomically(path, description_text(description, "", Findings()))
    doubt_overlaps(load_robot(path), findings)
    write_atomically(
        path, description_text(description, request.made_by, findings)
    )
    return load_robot(path, floor_height=0.03)


def _judge_sizes(urdf: Urdf, robot: RobotModel, findings: Findings) -> None:
    """Reports links and arms whose sizes suggest wrong units."""
    reach = arm_reach(robot)
    findings.find("reach", f"{reach:.2f} m with the arm stretched out")
    if not _SHORTEST < reach < _LONGEST:
        findings.doubt("reach", f"is {reach:.3g} m; {_UNITS}")
    for gap in find_link_gaps(urdf, robot):
        findings.doubt(f"joint {gap.joint}", f"{gap}; {_UNITS}")


def _srdf(
    request: ImportRequest, urdf: Urdf, said: Srdf, findings: Findings
) -> Srdf:
    """Returns the data of the SRDF, or else those of the robot's file."""
    path = request.srdf or find_srdf(request.source, urdf.name)
    if path is None:
        if said.allowed_collisions:
            pairs = [f"{a} and {b}" for a, b in said.allowed_collisions]
            findings.find("may touch", listed(pairs, 3))
        return said
    srdf = read_srdf(path, urdf)
    findings.find(
        "SRDF",
        f"{path.name}: {len(srdf.states)} states,"
        f" {len(srdf.allowed_collisions)} pairs of links that may touch",
    )
    return srdf


def _guessed_base(urdf: Urdf, srdf: Srdf, findings: Findings) -> str:
    if srdf.is_planar:
        findings.guess(
            "base",
            "omni, since its SRDF has a planar joint; --base sets another",
        )
        return OMNI
    if has_wheels(urdf):
        findings.guess(
            "base", "differential, since it has wheels; --base sets another"
        )
        return DIFFERENTIAL
    findings.guess("base", "fixed to the world; --base sets another")
    return FIXED


def _described(
    urdf: Urdf,
    arm: ArmChoice,
    limits: list[JointLimits],
    base: str,
    folder: Path,
    findings: Findings,
) -> RobotDescription:
    """Writes the model file, and makes the description without a home."""
    name = "".join(c if c.isalnum() else "_" for c in urdf.name).lower()
    model = folder / f"{name}.urdf"
    for tag in _LEFT_OUT:
        for element in urdf.root.findall(tag):
            urdf.root.remove(element)
    for joint in urdf.joints.values():
        for tag in ("mimic", "safety_controller", "calibration"):
            for element in joint.element.findall(tag):
                joint.element.remove(element)
        # This element is removed, since Drake does not simulate it and warns
        # for each joint.
        for dynamics in joint.element.findall("dynamics"):
            dynamics.attrib.pop("friction", None)
    joints = [joint.name for joint in arm.joints]
    _add_motors(urdf, joints)
    urdf.write(model)
    mount = _mount(urdf, arm)
    drives, floor = None, [mount] if mount != "world" else []
    if base != FIXED:
        lowest = lowest_points(model)
        ground = min(lowest.values(), default=0.0)
        moved = _moved_links(urdf, arm)
        floor = [
            link
            for link, z in lowest.items()
            if link not in moved and z - ground < _ON_FLOOR
        ]
        drives = add_base_joints(urdf, base, -ground)
        _add_motors(urdf, JOINTS)
        if abs(ground) > 0.005:
            findings.guess(
                "floor",
                f"{-ground:.3f} m below {drives}, where the lowest"
                " point of the robot is",
            )
        urdf.write(model)
    of_base = base_limits(base, findings)
    all_limits = [*of_base, *limits]
    return RobotDescription(
        name=name,
        model=model.name,
        base=None
        if drives is None
        else MobileBase(DRIVES[base], list(JOINTS), drives),
        arm=Arm("arm", joints, mount),
        end_effector_frame=arm.end_effectors.get("", ""),
        end_effectors={k: x for k, x in arm.end_effectors.items() if k},
        velocity_limits=[limit.velocity for limit in all_limits],
        acceleration_limits=[limit.acceleration for limit in all_limits],
        home=[0.0] * len(joints),
        locked=arm.locked,
        floor_links=floor,
        spheres={"covering": "spheres.yaml"},
        source=str(folder / f"{name}.yaml"),
    )


def _mount(urdf: Urdf, arm: ArmChoice) -> str:
    """Returns the link that carries all arms: their last common link."""
    carriers = [
        [urdf.base, *(joint.child for joint in urdf.chain(joint.parent))]
        for joint in arm.joints
        if not any(other in arm.joints for other in urdf.chain(joint.parent))
    ]
    shared = [link for link in carriers[0] if all(link in c for c in carriers)]
    return shared[-1]


def _with_allowed_collisions(
    description: RobotDescription, srdf: Srdf
) -> RobotDescription:
    """Adds the SRDF's allowed collisions to the description.

    They have an effect only on self-collision with hulls.
    """
    field = "allowed_collisions"
    if field not in {known.name for known in dc.fields(description)}:
        return description
    pairs = [list(pair) for pair in srdf.allowed_collisions]
    return dc.replace(description, **{field: pairs})


def _add_motors(urdf: Urdf, joints: Sequence[str]) -> None:
    """Gives each commanded joint a motor, and removes all others.

    A dynamic station and `hardware-sim` need the motors. Motors in the file may
    be on other joints, or have gears and interfaces that Drake does not
    support.
    """
    urdf.root.extend([transmission_element(joint) for joint in joints])


def _moved_links(urdf: Urdf, arm: ArmChoice) -> set[str]:
    """Names of the links that joints of the arm move."""
    return {
        link for link in urdf.links if set(urdf.chain(link)) & set(arm.joints)
    }


def _surface_options(urdf: Urdf, arm: ArmChoice, base: str) -> SurfaceOptions:
    """Selects all links with shapes, and weights them."""
    moved = _moved_links(urdf, arm)
    chains = [
        [joint for joint in urdf.chain(tip) if joint.moves]
        for tip in arm.end_effectors.values()
    ]
    wrist = {joint for chain in chains for joint in chain[-2:]}
    weights = {}
    links = []
    for link in urdf.links:
        if urdf.links[link].find("collision") is None:
            continue
        links.append(link)
        if wrist & set(urdf.chain(link)):
            weights[link] = _HAND_WEIGHT
        elif link not in moved and base == FIXED:
            weights[link] = _STILL_WEIGHT
    return SurfaceOptions(tuple(links), weights=weights)


def _chosen_home(
    robot: RobotModel, srdf: Srdf, findings: Findings
) -> list[float]:
    """Returns the first usable named state of the robot's files, or a guess.

    A state is usable if it names most of the arm's joints, is within their
    limits up to rounding, and if links overlap hardly more than in the guess.
    """
    guess = guess_home(robot)
    joints = robot.description.arm.joints
    arm = slice(robot.n_q - len(joints), robot.n_q)
    lower, upper = robot.position_lower[arm], robot.position_upper[arm]
    for name, positions in srdf.homes():
        if 2 * sum(joint in positions for joint in joints) <= len(joints):
            continue
        home = np.array([positions.get(joint, 0.0) for joint in joints])
        is_inside = (home > lower - ROUNDING) & (home < upper + ROUNDING)
        margin = np.minimum(_OFF_LIMITS, 0.01 * (upper - lower))
        home = np.clip(home, lower + margin, upper - margin)
        if is_inside.all() and tightness(robot, home) <= 1.2 * tightness(
            robot, guess
        ):
            findings.find("home", f"{name!r}, a state that its files name")
            return home.tolist()
    findings.guess(
        "home",
        listed([f"{x:g}" for x in guess], 12)
        + ": free of self-collision, away from limits",
    )
    return guess.tolist()
