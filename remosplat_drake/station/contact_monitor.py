"""`ContactMonitor`: true contacts between links and things, by names."""

import dataclasses as dc

from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import GeometryId, SceneGraphInspector
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.mover_bodies import MOVERS


@dc.dataclass(frozen=True)
class ContactReport:
    """Which bodies touch each other; copying returns the object itself.

    Attributes:
        scene: Pairs of a robot's link and a geometry of the scene that touch,
            sorted, each once.
        robot: Pairs of the robot's links that touch, sorted, each once.
        movers: Pairs of a robot's link and the name of a mover that touch,
            sorted, each once.
    """

    scene: tuple[tuple[str, str], ...] = ()
    robot: tuple[tuple[str, str], ...] = ()
    movers: tuple[tuple[str, str], ...] = ()

    def __deepcopy__(self, memo) -> "ContactReport":
        return self


class ContactMonitor(LeafSystem):
    """Reports the contacts of a plant by names.

    .. pydrake_system::

        name: ContactMonitor
        input_ports:
        - contact_results
        output_ports:
        - cheat.contact

    `contact_results` is the plant's port of that name; `cheat.contact` gives
    a `ContactReport` of the plant's last step, empty before the first.
    """

    def __init__(
        self, *, plant: MultibodyPlant, inspector: SceneGraphInspector
    ):
        """Declares the ports.

        Args:
            plant: The finalized plant, with point contact.
            inspector: Inspector of the scene graph that holds its geometry.
        """
        super().__init__()
        self._movers = set()
        if plant.HasModelInstanceNamed(MOVERS):
            instance = plant.GetModelInstanceByName(MOVERS)
            self._movers = set(map(int, plant.GetBodyIndices(instance)))
        self._world = int(plant.world_body().index())
        self._body_name = {
            i: plant.get_body(BodyIndex(i)).name()
            for i in range(plant.num_bodies())
        }
        self._scene_name: dict[GeometryId, str] = {
            geometry: inspector.GetName(geometry).split("::")[-1]
            for geometry in plant.GetCollisionGeometriesForBody(
                plant.world_body()
            )
        }
        self._input = self.DeclareAbstractInputPort(
            "contact_results", AbstractValue.Make(ContactResults())
        )
        self.DeclareAbstractOutputPort(
            ports.CHEAT_CONTACT,
            lambda: Value(ContactReport()),
            self._calc,
            {self._input.ticket()},
        )

    def _calc(self, context: Context, output: Value) -> None:
        results = self._input.Eval(context)
        scene, robot, movers = set(), set(), set()
        for i in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(i)
            pair = info.point_pair()
            sides = [
                (int(info.bodyA_index()), pair.id_A),
                (int(info.bodyB_index()), pair.id_B),
            ]
            moving = [b for b, _ in sides if b in self._movers]
            if moving:
                (link,) = (b for b, _ in sides if b not in moving)
                name = self._body_name[moving[0]].partition(": ")[2]
                movers.add((self._body_name[link], name))
                continue
            links = sorted(
                self._body_name[body]
                for body, _ in sides
                if body != self._world
            )
            if len(links) == 2:
                robot.add((links[0], links[1]))
                continue
            (obstacle,) = (
                self._scene_name[geometry]
                for body, geometry in sides
                if body == self._world
            )
            scene.add((links[0], obstacle))
        output.set_value(
            ContactReport(
                tuple(sorted(scene)),
                tuple(sorted(robot)),
                tuple(sorted(movers)),
            )
        )
