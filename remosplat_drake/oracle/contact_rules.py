"""`ContactRule`: a separate stopping distance between some links and an object.

The controller keeps all distances between a robot and its scene at or above the
stopping distance d_s. A rule sets another distance d_o for pairs of a link and
an object, or no distance if contact is intended. To implement the rule, the map
adds a relief

    r = d_s - d_o

to the distances of these pairs. If the distance that the map reports for a pair
is at least d_s, the true distance is at least d_o. The relief of a pair is
constant. So a 1-Lipschitz map remains 1-Lipschitz, and the guarantees of
verification hold for the reported distances. The distances of pairs without a
rule do not change.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

EXEMPT = None
"""The stopping distance of a link and an object that may touch."""


@dc.dataclass(frozen=True)
class ContactRule:
    """The distance that some links keep from an object.

    Attributes:
        object: Name of the object.
        links: Names of the links; these may include an object that the robot
            carries.
        stopping: Stopping distance between these links and the object [m]. It
            is negative if the model shapes may overlap because they are larger
            than the real shapes. `EXEMPT` allows contact.
    """

    object: str
    links: frozenset[str]
    stopping: float | None = EXEMPT

    def relief(self, usual: float) -> float:
        """Returns the relief for the object and each link [m]; inf if `EXEMPT`.

        Args:
            usual: The smallest stopping distance d_s that the controller uses
                [m]. If it uses a larger one, the distance of the pairs
                increases by the same amount.
        """
        return np.inf if self.stopping is None else usual - self.stopping


def reliefs(
    rules: Sequence[ContactRule],
    links: Sequence[str],
    objects: Sequence[str],
    usual: float,
) -> np.ndarray:
    """Computes the relief for each pair of a robot sphere and an object.

    Args:
        rules: The contact rules. If several rules apply to a pair, the greatest
            relief is used.
        links: Name of the link of each of the robot's n spheres.
        objects: Names of the k objects.
        usual: The smallest stopping distance that the controller uses [m].

    Returns:
        The reliefs, shape (n + 1, k) [m]. The last row is for spheres that
        enclose several of the robot's spheres. It contains the least relief of
        each column, but at most 0.
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
