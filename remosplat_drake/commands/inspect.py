"""`remosplat inspect`: shows the depth views of one of the robot's spheres."""

import argparse
from pathlib import Path

import numpy as np
from pydrake.systems.framework import DiagramBuilder

from remosplat_drake.app.map_knowledge import examine_map, target_places
from remosplat_drake.app.world import World, load_world
from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.base.tcp_port import check_free
from remosplat_drake.commands.gate_keeping import describe
from remosplat_drake.commands.hold import add_page_arguments, hold, open_page
from remosplat_drake.commands.run_page import show_verdict
from remosplat_drake.commands.splat_scenario import load_given
from remosplat_drake.commands.tables import open_console
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.view_images import SphereViews, look_around
from remosplat_drake.recording.trajectory import load_trajectory
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.safety.gates import SILENCE
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat
from remosplat_drake.visualization.depth_views import (
    draw_depth_views,
    format_length,
    save_picture,
)
from remosplat_drake.visualization.page import MeshcatPage
from remosplat_drake.visualization.page_state import still
from remosplat_drake.visualization.robot_view import AddRobotView
from remosplat_drake.visualization.sensor_view import SensorView
from remosplat_drake.visualization.splat_view import SplatView
from remosplat_drake.visualization.unseen_space import show_unseen_space

_BEHIND = (-1.0, -1.2, 0.7)
"""Position of the page's camera relative to the sphere, in W [m]."""

EXAMPLES = """
remosplat inspect TableReach --sphere panda_hand --output hand.png
remosplat inspect kitchen.yaml --page
"""
"""Examples at the end of `--help`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declares the command's flags."""
    parser.add_argument(
        "scenario",
        nargs="?",
        help="NAME, FILE or FILE:NAME (see `remosplat scenarios`), or a splat"
        " file",
    )
    parser.add_argument(
        "--sphere",
        metavar="INDEX|LINK",
        help=(
            "index of a sphere; or name of a link, of whose spheres the one "
            "nearest to the scene is used (default: the robot's sphere that "
            "is nearest to the scene)"
        ),
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--configuration",
        type=float,
        nargs="+",
        metavar="Q",
        help="configuration q of the robot (default: the start) [m, rad]",
    )
    where.add_argument(
        "--trajectory",
        type=Path,
        metavar="FILE",
        help=(
            "use the configuration of a recorded trajectory.npz at the tick "
            "--tick"
        ),
    )
    parser.add_argument(
        "--tick",
        type=int,
        default=-1,
        help=(
            "index of a tick of --trajectory; negative indices count from "
            "the end (default: -1)"
        ),
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE.png",
        default=Path("results/depth_views.png"),
        help="file of the picture (default: results/depth_views.png)",
    )
    parser.add_argument(
        "--page",
        action="store_true",
        help="show robot, splat and the depth view's rays in the browser",
    )
    parser.add_argument(
        "--save-html",
        type=Path,
        metavar="FILE",
        help="write the page as one static file",
    )
    parser.add_argument(
        "--scenario-text",
        default="",
        metavar="YAML",
        help="YAML of settings that override the scenario",
    )
    add_page_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Writes the picture, and serves the page if a flag requests it."""
    console = open_console(stderr=True)
    if arguments.page or arguments.save_html:
        check_free(arguments.host, arguments.port)
    scenario = load_given(arguments.scenario, arguments.scenario_text, console)
    world = load_world(scenario)
    if world.splat_W is None:
        raise FieldError(scenario.source, "scene.splat", "inspect needs one")
    q, place = _configuration(arguments, world)
    # The views have the settings of the scenario's depth oracle, if it has one.
    sensor = getattr(_map_field(world), "sensor", DepthSensor())
    spheres = world.robot.spheres_at(q)
    candidates = _candidates(arguments.sphere, world.robot.spheres.links)
    i = _nearest(world.splat_W, sensor, spheres, candidates)
    views = look_around(world.splat_W, sensor, spheres, i)
    title = f"Sphere {i} on {world.robot.spheres.links[i]}"
    where = scenario.name + place
    save_picture(
        draw_depth_views(views, title, f"{where}   ·   {_facts(views)}"),
        arguments.output,
    )
    knowledge = examine_map(scenario, world, target_places(scenario, world))
    gates = [g for g in knowledge.gates if g.leads_to(False) != SILENCE]
    describe(knowledge, gates, console)
    console.print(f"{title}: {_facts(views)}; see {arguments.output}")
    if arguments.page or arguments.save_html:
        page = show(world, q, views, open_page(arguments))
        page.show(still(f"{title}: {_facts(views)}"))
        show_verdict(page, knowledge)
        if arguments.save_html:
            page.save_html(arguments.save_html)
        if arguments.page:
            console.print(f"watch at [bold]{page.url}[/bold]")
            hold(arguments.hold, page, console)
    return 0


def _map_field(world: World) -> DistanceField:
    """Returns the field of the splat, without the field of unseen space."""
    field = world.field
    composite = isinstance(field, CompositeDistanceField)
    return field.parts[0] if composite else field


def _configuration(
    arguments: argparse.Namespace, world: World
) -> tuple[np.ndarray, str]:
    """Returns the configuration of the robot, and its description."""
    n_q = world.robot.n_q
    if arguments.configuration is not None:
        if len(arguments.configuration) != n_q:
            raise FieldError(
                "inspect", "--configuration", f"expected {n_q} numbers"
            )
        return np.array(arguments.configuration), ""
    if arguments.trajectory is None:
        return world.q0, " at the start"
    trajectory = load_trajectory(arguments.trajectory)
    ticks = len(trajectory.q)
    if trajectory.q.shape[1] != n_q:
        raise FieldError(
            "inspect",
            "--trajectory",
            f"has {trajectory.q.shape[1]} positions, but the robot has {n_q}",
        )
    if not -ticks <= arguments.tick < ticks:
        raise FieldError(
            "inspect",
            "--tick",
            f"{arguments.tick} is not {-ticks} to {ticks - 1}",
        )
    tick = range(ticks)[arguments.tick]
    return trajectory.q[tick], f" at tick {tick}"


def _nearest(
    splat_W: GaussianSplat,
    sensor: DepthSensor,
    spheres: Spheres,
    candidates: list[int],
) -> int:
    """Returns the index of the sphere that is nearest to a surface it sees."""
    field = DepthRasterizationField(splat_W, sensor, nearest_only=True)
    asked = spheres.select(np.array(candidates))
    distance = field.clearances(asked).per_sphere(len(candidates))
    return candidates[int(distance.argmin())]


def _facts(views: SphereViews) -> str:
    nearest = views.clearances.min()
    sight = (
        f"clearance {format_length(nearest)}"
        if np.isfinite(nearest)
        else "nothing in sight"
    )
    return f"radius {format_length(views.radius)}, {sight}"


def _candidates(chosen: str | None, links: tuple[str, ...]) -> list[int]:
    """Returns the indices of the spheres that a flag selects, or of all."""
    n = len(links)
    if chosen is None:
        return list(range(n))
    if chosen.lstrip("-").isdigit():
        if not 0 <= int(chosen) < n:
            raise FieldError(
                "inspect", "--sphere", f"{chosen} is not in 0 to {n - 1}"
            )
        return [int(chosen)]
    if chosen not in links:
        raise FieldError(
            "inspect", "--sphere", unknown_name("link", chosen, set(links))
        )
    return [i for i in range(n) if links[i] == chosen]


def show(
    world: World,
    q: np.ndarray,
    views: SphereViews,
    page: MeshcatPage,
) -> MeshcatPage:
    """Draws the robot at q, the map and the depth view's rays on a page."""
    SplatView(page, world.splat_W or GaussianSplat.empty())
    if world.seen is not None:
        seen = world.seen
        show_unseen_space(page, seen.coverage, seen.X_WG, shown=False)
    SensorView(page, views)
    builder = DiagramBuilder()
    configuration = AddRobotView(builder, world.robot, page)
    builder.ExportInput(configuration, "configuration")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    diagram.GetInputPort("configuration").FixValue(context, q)
    diagram.ForcedPublish(context)
    page.look_from(
        p_WC=(views.p_WS + _BEHIND).tolist(), p_WT=views.p_WS.tolist()
    )
    return page
