"""`Workshop`: properties of robot and objects, for making a task's steps."""

import dataclasses as dc
from collections.abc import Callable, Mapping, Sequence

from pydrake.math import RigidTransform

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass(frozen=True, eq=False)
class Workshop:
    """Properties of the robot and the objects, to check and complete steps.

    Attributes:
        robot: The robot.
        objects: Names of the objects.
        overhang: Distances by which the spheres of carried objects exceed the
            objects' surfaces, keyed by the objects' names [m].
        max_widths: Greatest openings of the hands by end effector [m].
        is_stopped: Whether an object between the fingers stops the fingers;
            false on a kinematic station.
        where: File and name of the scenario, for errors.
        plans: Whether the controller plans paths.
        places: Function that returns free poses X_WO of an object on its
            support, the best first, or raises a `RemoSplatError`. Its arguments
            are the names of the object and the support, a point in W near which
            the object shall stand (or None), and the index of the end effector.
    """

    robot: RobotModel
    objects: tuple[str, ...]
    overhang: Mapping[str, float]
    max_widths: Mapping[int, float]
    is_stopped: bool
    where: str
    plans: bool = True
    places: Callable[
        [str, str, Sequence[float] | None, int], Sequence[RigidTransform]
    ] = lambda thing, support, near, effector: ()

    def error(self, field: str, problem: str) -> FieldError:
        """Makes an error about a field of the scenario."""
        return FieldError(self.where, field, problem)

    def object(self, name: str, field: str) -> str:
        """Returns the name of an object, after a check that it exists.

        Raises:
            FieldError: There is no object of this name.
        """
        if name not in self.objects:
            raise self.error(field, unknown_name("object", name, self.objects))
        return name

    def width(self, width: float | None, effector: int, field: str) -> float:
        """Returns a width, after a check that the hand can open so far.

        None means the greatest opening of the hand.

        Raises:
            FieldError: There is no hand, or its greatest opening is less.
        """
        most = self.max_widths.get(effector)
        if most is None:
            raise self.error(field, "the robot has no hand")
        if width is None:
            return most
        if width > most:
            problem = f"the hand opens to {most:g} m at most, got {width:g}"
            raise self.error(field, problem)
        return width
