"""`ContactMonitor`: outputs true contacts between bodies as pairs of names."""

import dataclasses as dc
from collections.abc import Iterator

from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import GeometryId, SceneGraphInspector
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Context, LeafSystem

from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.mover_bodies import MOVERS
from remosplat_drake.station.object_bodies import OBJECTS

Pairs = tuple[tuple[str, str], ...]
"""Sorted pairs of names, without duplicates."""

_ROBOT, _MOVER, _OBJECT, _SCENE = range(4)  # In the order of a pair's sides.


@dc.dataclass(frozen=True)
class ContactReport:
    """Pairs of bodies in contact; copying returns the object itself.

    Attributes:
        scene: Pairs of a link of the robot and a geometry of the scene.
        robot: Pairs of two links of the robot.
        movers: Pairs of a link of the robot and a mover (moving object).
        objects: Pairs of a link of the robot and an object.
        others: Pairs of an object and another object or a geometry of the
            scene, and pairs of a mover and an object.
    """

    scene: Pairs = ()
    robot: Pairs = ()
    movers: Pairs = ()
    objects: Pairs = ()
    others: Pairs = ()

    def __deepcopy__(self, memo) -> "ContactReport":
        return self


_FIELDS = {
    (_ROBOT, _SCENE): "scene",
    (_ROBOT, _ROBOT): "robot",
    (_ROBOT, _MOVER): "movers",
    (_ROBOT, _OBJECT): "objects",
    (_OBJECT, _OBJECT): "others",
    (_OBJECT, _SCENE): "others",
    (_MOVER, _OBJECT): "others",
}
"""For each pair of kinds of bodies: the attribute of `ContactReport` that
contains their contacts."""


class ContactMonitor(LeafSystem):
    """Outputs the contacts in a plant as pairs of names.

    .. pydrake_system::

        name: ContactMonitor
        input_ports:
        - contact_results
        output_ports:
        - cheat.contact

    `contact_results` is connected to the plant's port of this name.
    `cheat.contact` outputs a `ContactReport` of the plant's last step, which is
    empty before the first step.
    """

    def __init__(
        self, *, plant: MultibodyPlant, inspector: SceneGraphInspector
    ):
        """Declares the ports.

        Args:
            plant: The finalized plant.
            inspector: Inspector of the scene graph that holds its geometry.
        """
        super().__init__()
        self._named: dict[GeometryId, tuple[int, str]] = {}
        for i in range(plant.num_bodies()):
            body = plant.get_body(BodyIndex(i))
            kind = _kind(plant, body)
            for geometry in plant.GetCollisionGeometriesForBody(body):
                name = body.name()
                if kind == _SCENE:
                    name = inspector.GetName(geometry).split("::")[-1]
                elif kind == _MOVER:
                    name = name.partition(": ")[2]
                self._named[geometry] = kind, name
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
        found: dict[str, set[tuple[str, str]]] = {}
        for pair in touching(self._input.Eval(context)):
            (kind_a, a), (kind_b, b) = sorted(self._named[g] for g in pair)
            found.setdefault(_FIELDS[kind_a, kind_b], set()).add((a, b))
        report = {field: tuple(sorted(of)) for field, of in found.items()}
        output.set_value(ContactReport(**report))


def touching(results: ContactResults) -> Iterator[tuple[GeometryId, ...]]:
    """Lists the pairs of geometries that touch, at points or on surfaces."""
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i).point_pair()
        yield point.id_A, point.id_B
    for i in range(results.num_hydroelastic_contacts()):
        surface = results.hydroelastic_contact_info(i).contact_surface()
        yield surface.id_M(), surface.id_N()


def _kind(plant: MultibodyPlant, body: RigidBody) -> int:
    """Returns the kind of a body: robot, mover, object or scene."""
    if body.index() == plant.world_body().index():
        return _SCENE
    instance = plant.GetModelInstanceName(body.model_instance())
    return {MOVERS: _MOVER, OBJECTS: _OBJECT}.get(instance, _ROBOT)
