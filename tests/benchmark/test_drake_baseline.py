"""Drake's differential inverse kinematics as a baseline."""

import numpy as np
import pytest
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.benchmark.drake_baseline import make_control
from remosplat_drake.benchmark.drake_baseline_model import make_collision_model
from remosplat_drake.benchmark.methods import load_methods
from remosplat_drake.benchmark.result import LOCAL_MINIMUM, SUCCESS
from remosplat_drake.benchmark.scene_case import SceneCase
from remosplat_drake.benchmark.trial import Trial, run_trial
from remosplat_drake.oracle.point_distance import PointDistanceField
from remosplat_drake.oracle.signed_distance import SignedDistanceField
from remosplat_drake.scene.primitive_scene import Cylinder, PrimitiveScene
from remosplat_drake.scene.rmmi import write_rmmi


def post_scene(frankie, x: float, y: float, ahead: float) -> PrimitiveScene:
    """A post on a floor, and a target `ahead` of where the hand starts."""
    X_WE = frankie.end_effector_pose(np.array([0, 0, 0, *frankie.home]))
    X_WE[0, 3] += ahead
    return PrimitiveScene(
        cylinders=(Cylinder(RigidTransform([x, y, 0.6]), 0.03, 0.6),),
        X_WE_target=RigidTransform(X_WE),
        X_WB_start=(0.0, 0.0, 0.0),
    ).with_floor()


def run(scene: PrimitiveScene, folder, limit: float):
    write_rmmi(folder / "scene.json", scene)
    case = SceneCase("post", "table", file=str(folder / "scene.json"))
    (method,) = load_methods(["drake-ik"], f"{{time_limit: {limit}}}")
    return run_trial(Trial(method, case))


def test_it_reaches_a_free_target(frankie, tmp_path):
    result = run(post_scene(frankie, 0.5, 2.0, 0.4), tmp_path, 5)
    assert result.outcome("text") == result.outcome("authors") == SUCCESS
    assert (result.method, result.gains) == ("drake-ik", "own")


def test_it_stops_before_a_post(frankie, tmp_path):
    q = np.array([0, 0, 0, *frankie.home])
    hand = frankie.end_effector_pose(q)[0, 3]
    result = run(post_scene(frankie, hand + 0.3, 0.0, 0.6), tmp_path, 6)
    assert result.outcome("text") == LOCAL_MINIMUM
    assert result.text is not None
    # The stopping distance, but for the curvature within one tick.
    assert result.text.minimum_distance == pytest.approx(0.021, abs=1e-3)


def test_its_collision_model_measures_as_ours_does(frankie):
    scene = post_scene(frankie, 0.9, 0.2, 0.5)
    truth = SignedDistanceField(scene)
    model = make_collision_model(frankie, scene)
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = np.array([*rng.uniform(-0.3, 0.3, 3), *frankie.home])
        q[3:] += rng.uniform(-0.4, 0.4, 7)
        ours = truth.clearances(frankie.spheres_at(q)).minimum()
        theirs = model.checker.CalcRobotClearance(model.positions(q), 5.0)
        assert min(theirs.distances()) == pytest.approx(ours, abs=1e-6)


def test_its_base_does_not_slip(frankie):
    """A target to the side is approached by turning, at legal speeds."""
    scene = post_scene(frankie, 3.0, 3.0, 0.0)
    q = np.array([0.2, -0.1, 0.4, *frankie.home])
    X_WT = frankie.end_effector_pose(q)
    X_WT[:2, 3] += frankie.end_effector_pose(q)[:2, 1]
    control = make_control(frankie, SignedDistanceField(scene), X_WT, 0.05)
    u = control(q, np.zeros(frankie.n_u))
    assert u.shape == (frankie.n_u,)
    assert (np.abs(u) <= frankie.velocity_limit).all()
    # The twist that our kinematics predict is the one that was asked for.
    v = frankie.state(q).Jv_WE @ u
    direction = X_WT[:3, 3] - frankie.end_effector_pose(q)[:3, 3]
    assert v @ direction == pytest.approx(0.5, abs=0.01)


def test_it_needs_solids(frankie):
    cloud = PointDistanceField(np.zeros((1, 3)))
    with pytest.raises(RemoSplatError, match="true solids"):
        make_control(frankie, cloud, np.eye(4), 0.05)
