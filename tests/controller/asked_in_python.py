"""A map that kernels cannot ask: what compiled code is compared with."""

from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import Clearances, DistanceField


class AskedInPython(DistanceField):
    """A map that only Python can ask, so that every step is a readable one."""

    def __init__(self, field: DistanceField):
        """Wraps a map."""
        self._field = field
        self.revision = field.revision
        self.is_lipschitz = field.is_lipschitz

    def clearances(
        self, spheres: Spheres, max_distance: float = float("inf")
    ) -> Clearances:
        """Answers as the map does."""
        return self._field.clearances(spheres, max_distance)
