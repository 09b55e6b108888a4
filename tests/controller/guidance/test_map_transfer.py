"""Maps that go through a pipe, arrays and all."""

import dataclasses as dc
from multiprocessing import Pipe
from threading import Thread

import numpy as np

from remosplat_drake.base.array_pipe import (
    ArrayHeader,
    receive_arrays,
    send_arrays,
)
from remosplat_drake.controller.guidance.planner import SidePlanner
from remosplat_drake.controller.guidance.rule_transfer import (
    pack_rule,
    unpack_rule,
)
from remosplat_drake.generation.primitive_surfels import surfel_splat
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.oracle.composite import CompositeDistanceField
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField
from remosplat_drake.oracle.unknown_space import UnknownSpaceField
from remosplat_drake.robot.sphere_model import Spheres
from remosplat_drake.signals.distance_field import DistanceField
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def sent(field: DistanceField) -> tuple[ArrayHeader, DistanceField]:
    """What arrives of a field; and what came before its arrays."""
    ours, theirs = Pipe()
    with ours, theirs:
        sender = Thread(target=send_arrays, args=(ours, field))
        sender.start()
        header = theirs.recv()
        received = receive_arrays(theirs, header)
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


def test_arrays_that_are_read_only_stay_so():
    """Or kernels would be compiled anew for the others' process."""
    field = SphereToEllipsoidField(surfel_splat(generate("table", 6)))
    _, received = sent(field)
    pairs = list(
        zip(
            flat(vars(field).values()),
            flat(vars(received).values()),
            strict=True,
        )
    )
    assert not all(ours.flags.writeable for ours, _ in pairs)
    for ours, theirs in pairs:
        assert ours.flags.writeable == theirs.flags.writeable


def test_a_rule_arrives_as_it_was(toy):
    rule = toy.rule((toy.far, toy.near))
    rule = dc.replace(rule, arrived=len, planner=SidePlanner())
    received = unpack_rule(pack_rule(rule))
    before, after = (r.law.robot.arrays.values for r in (rule, received))
    for ours, theirs in zip(flat(before), flat(after), strict=True):
        np.testing.assert_array_equal(ours, theirs)
        assert ours.flags.writeable == theirs.flags.writeable


def flat(values):
    """All arrays in nested tuples."""
    for value in values:
        if isinstance(value, tuple):
            yield from flat(value)
        elif isinstance(value, np.ndarray):
            yield value


def test_an_empty_map_arrives():
    _, received = sent(SphereToEllipsoidField(GaussianSplat.empty()))
    assert not len(received.clearances(Spheres.at(np.zeros((1, 3)))).sphere)
