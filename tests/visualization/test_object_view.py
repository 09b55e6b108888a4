"""Objects on the page."""

import dataclasses as dc

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from remosplat_drake.robot.fitting.link_spheres import LinkSpheres
from remosplat_drake.robot.payload import Payload
from remosplat_drake.scene.objects.scene_object import SceneObject
from remosplat_drake.scene.primitive_scene import Box, Cylinder
from remosplat_drake.signals.tick_report import TickReport
from remosplat_drake.visualization.object_view import OBJECTS, ObjectView

CAN = SceneObject("can", Cylinder(RigidTransform([1, 0, 0.5]), 0.03, 0.06))
CRATE = SceneObject("crate", Box(RigidTransform([0, 1, 0]), np.full(3, 0.1)))


def test_an_object_stands_where_it_is_or_moves_with_the_hand(
    page, frankie, pose_of
):
    view, q = ObjectView(page=page, robot=frankie), frankie.q_home
    context = view.CreateDefaultContext()
    view.GetInputPort("configuration").FixValue(context, q)
    objects = Value[object]((CAN, CRATE))
    view.GetInputPort("objects").FixValue(context, objects)
    report = TickReport.before_first(frankie.n_q, frankie.n_u)

    def draw(report):
        view.GetInputPort("report").FixValue(context, Value[object](report))
        view.ForcedPublish(context)
        page.scene.settle()
        return [
            pose_of(page.meshcat, f"{OBJECTS}/{n}") for n in ("can", "crate")
        ]

    can, crate = draw(report)
    np.testing.assert_allclose(can[:3, 3], [1, 0, 0.5], atol=1e-9)
    np.testing.assert_allclose(crate[:3, 3], [0, 1, 0], atol=1e-9)
    X_LO = RigidTransform([0, 0, 0.1]).GetAsMatrix4()
    spheres = LinkSpheres(np.zeros((1, 3)), np.array([0.1]))
    payload = Payload("can", "panda_hand", X_LO, spheres, ())
    can, crate = draw(dc.replace(report, payload=payload))
    X_WL = frankie.body_poses(q)[frankie.tree.index("panda_hand")]
    np.testing.assert_allclose(can, X_WL @ X_LO, atol=1e-9)
    np.testing.assert_allclose(crate[:3, 3], [0, 1, 0], atol=1e-9)
