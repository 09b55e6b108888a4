"""An oracle: the true scene, with a margin around it."""

import dataclasses as dc
from typing import Annotated

from annotated_types import Interval

from remosplat_drake.base.ranges import Config
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.signals.distance_field import Clearances, DistanceField


@dc.dataclass
class Padded(Config):
    """Everything is thicker than it is."""

    # So much [m].
    margin: Annotated[float, Interval(ge=0, le=1)] = 0.1

    def make(self, splat_W, truth) -> DistanceField:
        """Builds the field."""
        return PaddedField(truth, self.margin)


class PaddedField(DistanceField):
    """Distances less a margin."""

    def __init__(self, truth, margin: float):
        self._field, self._margin = SignedDistanceField(truth), margin
        self.revision = f"{self._field.revision} {margin}"

    def clearances(self, spheres, max_distance=float("inf")):
        """See `DistanceField`."""
        found = self._field.clearances(spheres, max_distance + self._margin)
        return dc.replace(found, distance=found.distance - self._margin)


@dc.dataclass
class Nothing(Config):
    """Makes no field at all."""

    def make(self, splat_W, truth):
        """Forgets to."""


@dc.dataclass
class Blind(Config):
    """Makes a field that knows nothing."""

    def make(self, splat_W, truth) -> DistanceField:
        """Builds the field."""
        return BlindField()


class BlindField(DistanceField):
    """Answers that no distance is known."""

    revision = "blind"

    def clearances(self, spheres, max_distance=float("inf")):
        """See `DistanceField`."""
        return Clearances.unknown(len(spheres))
