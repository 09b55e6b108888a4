"""`ContactRule`: another stopping distance for some links and an object.

All distances of a robot to its scene are at least the stopping distance d_s.
A rule sets another distance d_o for pairs of some links and one object, or no
distance if contact is intended. The map implements the rule by a relief

    r = d_s - d_o

which it adds to the distances of these pairs. If the reported distance of a
pair is at least d_s, its true distance is at least d_o. The relief of a pair is
constant, so a 1-Lipschitz map remains 1-Lipschitz, and the guarantees of
verification hold for the reported distances. Distances of pairs without a rule
are not changed.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

EXEMPT = None
"""The distance of a pair that may touch."""


@dc.dataclass(frozen=True)
class ContactRule:
    """The distance that some links keep from an object.

    Attributes:
        object: Name of the object.
        links: Names of the links; these may include an object that the robot
            carries.
        stopping: Distance that they keep from the object [m]. It is negative if
            shapes that are larger than the real ones may overlap; `EXEMPT` for
            no distance.
    """

    object: str
    links: frozenset[str]
    stopping: float | None = EXEMPT

    def relief(self, usual: float) -> float:
        """Returns the relief for the object and each link [m]; inf for contact.

        Args:
            usual: The smallest stopping distance in use [m]; with a larger one,
                the distance of the pairs increases by the same amount.
        """
        return np.inf if self.stopping is None else usual - self.stopping


def reliefs(
    rules: Sequence[ContactRule],
    links: Sequence[str],
    objects: Sequence[str],
    usual: float,
) -> np.ndarray:
    """Computes the relief of each of a robot's spheres from each object.

    Args:
        rules: The rules; if several apply to a pair, the greatest relief
            counts.
        links: The link of each of the n spheres.
        objects: Names of the k objects.
        usual: The smallest stopping distance in use [m].

    Returns:
        Shape (n + 1, k) [m]. The last row contains the least relief of each
        column, for other spheres such as a ball around several of the robot's.
    """
    relief = np.zeros((len(links) + 1, len(objects)))
    names = list(objects)
    given = np.full(relief.shape, -np.inf)
    for rule in rules:
        if rule.object not in names:
            continue
        rows = [i for i, link in enumerate(links) if link in rule.links]
        column = names.index(rule.object)
        value = rule.relief(usual)
        given[rows, column] = np.maximum(given[rows, column], value)
    relief[given > -np.inf] = given[given > -np.inf]
    if len(links):
        relief[-1] = np.minimum(relief[:-1].min(axis=0), 0.0)
    return relief
