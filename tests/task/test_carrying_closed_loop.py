"""The promise, with something in the hand, and pairs of their own distances.

From any state in which nothing touches, and for any target: no pair of a sphere
and a solid comes nearer than its own stopping distance, less what the sphere
lacks of that to anything at the start; but for those that may touch. The
distances here are those of each pair, computed without reliefs.
"""

import numpy as np
import pytest
from carried import can_in_hand
from effort import effort
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from remosplat_drake.controller.controller_config import gain_set
from remosplat_drake.controller.tick.reactive_law import ReactiveLaw
from remosplat_drake.controller.tick.run_tick import run_tick
from remosplat_drake.oracle.contact_rules import ContactRule, reliefs
from remosplat_drake.oracle.object_field import ObjectField, with_objects
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder, PrimitiveScene

DT, ROUNDING = 0.05, 1e-9
OWN = 0.004
"""The distance that the arm keeps from the first object [m]."""


class World:
    """Random solids about the robot, three of which are objects.

    The hand may touch the second one, and what it carries the third.
    """

    def __init__(self, robot, rng):
        def pose():
            rpy = RollPitchYaw(rng.uniform(-3, 3, 3))
            p_WP = rng.uniform((-0.3, -0.8, 0.2), (1.4, 0.8, 1.2))
            return RigidTransform(rpy, p_WP)

        solids = [Box(pose(), rng.uniform(0.03, 0.2, 3)) for _ in range(3)]
        self.objects = [SceneObject(f"o{i}", x) for i, x in enumerate(solids)]
        self.rest = PrimitiveScene(
            boxes=(Box(pose(), rng.uniform(0.03, 0.2, 3)),),
            cylinders=(Cylinder(pose(), 0.05, 0.2),),
        )
        self.robot = robot
        links = np.array(robot.spheres.links)
        self.arm = np.array([x not in robot.payload.holders for x in links])
        self.held = links == "can"
        rules = [
            ContactRule("o0", frozenset(links[self.arm]), OWN),
            ContactRule("o1", robot.payload.holders),
            ContactRule("o2", frozenset({"can"})),
        ]
        relief = reliefs(rules, links, ["o0", "o1", "o2"], 0.021)
        self.field = with_objects(
            SignedDistanceField(self.rest), ObjectField(self.objects, relief)
        )

    def distances(self, q):
        """Of all spheres from the rest and from each object, (n, 4) [m]."""
        scenes = [self.rest]
        scenes += [PrimitiveScene(boxes=(o.solid,)) for o in self.objects]
        spheres = self.robot.spheres_at(q)
        n = len(spheres)
        return np.column_stack(
            [
                SignedDistanceField(scene).clearances(spheres).per_sphere(n)
                for scene in scenes
            ]
        )

    def stopping(self, usual):
        """What each of these pairs keeps, (n, 4) [m]."""
        kept = np.full((len(self.arm), 4), usual)
        kept[self.arm, 1] = OWN
        kept[~self.arm, 2] = -np.inf
        kept[self.held, 3] = -np.inf
        return kept


def drive(world, rng, ticks):
    """How far pairs stay above what they keep, and whether any has touched."""
    robot, q = world.robot, world.robot.q_home
    law = ReactiveLaw.make(gain_set("tuned"), robot.holding(None), DT)
    law, before = law.holding(robot.payload), world.distances(q)
    kept = world.stopping(law.collision.stopping)
    lacking = (kept - before).max(axis=1, keepdims=True).clip(min=0.0)
    floor, u = kept - lacking, np.zeros(robot.n_u)
    R_WT = RotationMatrix(RollPitchYaw(rng.uniform(-3, 3, 3)))
    # Mostly to what may be touched.
    goal = world.objects[rng.integers(1, 3)].X_WO.translation()
    X_WT = RigidTransform(R_WT, goal).GetAsMatrix4()
    above, touched = np.inf, False
    for k in range(ticks):
        rows = world.field.clearances(
            robot.spheres_at(q), law.collision.influence
        )
        u = run_tick(law, k * DT, q, X_WT, rows, world.field, u).command
        q = robot.advance(q, u, DT)
        distance = world.distances(q)
        above = min(above, (distance - floor).min())
        touched |= bool((distance < 0.0).any())
    return above, touched


def check(robot, seed, worlds, ticks):
    """Drives in many worlds, and returns how often something was touched."""
    rng = np.random.default_rng(seed)
    held = robot.holding(can_in_hand(robot, robot.q_home))
    touched = 0
    while worlds:
        world = World(held, rng)
        if world.distances(held.q_home).min() <= 0.0:
            continue
        worlds -= 1
        above, touches = drive(world, rng, ticks)
        assert above >= -ROUNDING
        touched += touches
    return touched


def test_every_pair_keeps_its_own_distance(frankie):
    # What may be touched is touched, or the rules would be idle.
    assert check(frankie, 0, worlds=12, ticks=90) > 0


@pytest.mark.slow
def test_every_pair_keeps_its_own_distance_in_many_worlds(frankie):
    assert check(frankie, 1, worlds=effort(60, 500), ticks=200) > 0
