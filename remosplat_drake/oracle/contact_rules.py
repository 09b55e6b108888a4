"""`ContactRule`: the distance that some links keep from an object.

All distances of a robot to its scene are at least the stopping distance d_s.
A rule says otherwise for pairs of some links and one object: another distance
d_o, or none at all, where contact is wanted. The map honours it by a relief

    r = d_s - d_o

by which it reports the distances of these pairs too large. A pair that keeps
d_s of what is reported keeps d_o of what is true. The relief of a pair does not
depend on where the robot is, so a reported distance changes as fast as the true
one: a map that is 1-Lipschitz stays so, and what is proved of it holds for the
reported distances. Those of all pairs without a rule are the true ones.
"""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np

EXEMPT = None
"""The distance of a pair that may touch."""


@dc.dataclass(frozen=True)
class ContactRule:
    """How near some links may come to an object.

    Attributes:
        object: Name of the object.
        links: Names of the links, an object that the robot carries among them.
        stopping: Distance that they keep from it [m]; negative for an overlap
            of shapes that are larger than what they stand for; `EXEMPT` for
            none.
    """

    object: str
    links: frozenset[str]
    stopping: float | None = EXEMPT

    def relief(self, usual: float) -> float:
        """Returns the relief of these pairs [m]; infinite if they may touch.

        Args:
            usual: The smallest stopping distance in use [m]: with a larger one
                the pairs keep as much more.
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
        rules: The rules; of several for a pair the greatest relief counts.
        links: The link of each of the n spheres.
        objects: Names of the k objects.
        usual: The smallest stopping distance in use [m].

    Returns:
        Shape (n + 1, k) [m]. The last row holds the least of each column: the
        relief of what is no sphere of the robot, such as a ball around several.
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
