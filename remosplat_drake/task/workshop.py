"""`Workshop`: the inputs from which steps of a scenario are made."""

import dataclasses as dc
from collections.abc import Mapping

from remosplat_drake.base.errors import FieldError, unknown_name
from remosplat_drake.robot.robot_model import RobotModel


@dc.dataclass(frozen=True, eq=False)
class Workshop:
    """What the steps of a scenario are made with.

    Attributes:
        robot: The robot.
        objects: Names of the objects.
        overhang: How far the spheres of carried objects reach beyond them, by
            the objects' names [m].
        max_widths: Greatest openings of the hands by end effector [m].
        is_stopped: Whether what is between the fingers stops them, which it
            does not on a kinematic station.
        where: The scenario that errors blame, as file and name.
        plans: Whether paths are planned.
    """

    robot: RobotModel
    objects: tuple[str, ...]
    overhang: Mapping[str, float]
    max_widths: Mapping[int, float]
    is_stopped: bool
    where: str
    plans: bool = True

    def error(self, field: str, problem: str) -> FieldError:
        """Makes an error about a field of the scenario."""
        return FieldError(self.where, field, problem)

    def object(self, name: str, field: str) -> str:
        """Returns a name, if there is such an object.

        Raises:
            FieldError: There is none.
        """
        if name not in self.objects:
            raise self.error(field, unknown_name("object", name, self.objects))
        return name

    def width(self, width: float | None, effector: int, field: str) -> float:
        """Returns an opening that a hand has; None means the greatest.

        Raises:
            FieldError: There is no hand, or one that opens less.
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
