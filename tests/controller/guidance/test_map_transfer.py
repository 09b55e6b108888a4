"""Maps that go through a pipe, arrays and all."""

from multiprocessing import Pipe
from threading import Thread

import numpy as np

from remosplat_drake.controller.guidance.map_transfer import (
    MapHeader,
    receive_map,
    send_map,
)
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def sent(field: DistanceField) -> tuple[MapHeader, DistanceField]:
    """What arrives of a field; and what came before its arrays."""
    ours, theirs = Pipe()
    with ours, theirs:
        sender = Thread(target=send_map, args=(ours, field))
        sender.start()
        header = theirs.recv()
        received = receive_map(theirs, header)
        sender.join()
    return header, received


def test_a_map_arrives_whole():
    unseen = np.zeros((4, 4, 4), bool)
    unseen[1:3, 1:3, 1:3] = True
    field = CompositeDistanceField(
        [
            SphereToEllipsoidField(surfel_splat(generate("table", 6))),
            UnknownSpaceField(unseen, np.zeros(3), 0.1),
        ]
    )
    header, received = sent(field)
    # The arrays are not in the pickle: that would be a copy of them all.
    assert len(header.body) < 5000 < sum(header.sizes)
    assert received.revision == field.revision
    spheres = Spheres.at(np.random.default_rng(0).uniform(0, 1, (20, 3)))
    before, after = (f.clearances(spheres) for f in (field, received))
    np.testing.assert_array_equal(before.distance, after.distance)
    np.testing.assert_array_equal(before.p_WC, after.p_WC)


def test_an_empty_map_arrives():
    _, received = sent(SphereToEllipsoidField(GaussianSplat.empty()))
    assert not len(received.clearances(Spheres.at(np.zeros((1, 3)))).sphere)
