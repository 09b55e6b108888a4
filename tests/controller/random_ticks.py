"""Ticks of which everything is drawn at random."""

import dataclasses as dc

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from remosplat_drake.controller.program.guidance import Guidance
from remosplat_drake.controller.program.path import Path
from remosplat_drake.controller.program.tick import Tick
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Mover, Movers
from remosplat_drake.signals.aim import Aim
from remosplat_drake.signals.distance_field import Clearances
from remosplat_drake.signals.target import Line, Target


def some_tick(robot: RobotModel, seed: int) -> Tick:
    """A tick of which everything is drawn at random, some of it extreme."""
    rng = np.random.default_rng(seed)
    lower = np.maximum(robot.position_lower, -4.0)
    upper = np.minimum(robot.position_upper, 4.0)
    q = rng.uniform(lower, upper)
    if rng.random() < 0.3:
        q = np.where(rng.random(len(q)) < 0.5, lower, q)  # At the limits.
    state = robot.state(q)
    m = rng.integers(0, 90)
    directions = rng.normal(size=(m, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    sphere = np.sort(rng.integers(0, len(robot.spheres), m))
    clearances = Clearances(
        sphere, rng.uniform(-0.02, 0.5, m), directions, np.zeros((m, 3))
    )
    X_WT = np.eye(4)
    X_WT[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    X_WT[:3, :3] *= np.linalg.det(X_WT[:3, :3])
    if rng.random() < 0.2:
        X_WT[:3, :3] = state.X_WE[:3, :3]
    X_WT[:3, 3] = state.X_WE[:3, 3] + rng.normal(size=3) * rng.choice(
        [0, 1e-4, 1]
    )
    targets = [some_target(X_WE, X_WT, rng) for X_WE in state.X_WEs]
    aim = some_aim(targets, rng)
    if seed % 5 == 4:
        aim = dc.replace(aim, q=q)
    tube = rng.uniform(0, 0.01, len(robot.spheres))
    movers = some_movers(rng, state.spheres.p_WS)
    return Tick(
        robot,
        state,
        aim,
        clearances,
        rng.normal(size=robot.n_u) * rng.choice([0.0, 0.1, 5.0]),
        0.01,
        some_guidance(robot, q, rng),
        tube if rng.random() < 0.5 else None,
        movers if rng.random() < 0.5 else None,
        rng.uniform(0.0, 0.2),
    )


def some_movers(rng, p_WS) -> Movers:
    """Up to three rounded boxes around the robot, which move and turn."""
    movers = []
    for name in ("Ada", "Bob", "door")[: rng.integers(4)]:
        about = p_WS[rng.integers(len(p_WS))] + rng.uniform(-0.8, 0.8, 3)
        turned = RotationMatrix(np.linalg.qr(rng.normal(size=(3, 3)))[0])
        movers.append(
            Mover(
                name,
                RigidTransform(turned, about),
                rng.uniform(0, 0.2, 3) * rng.integers(0, 2, 3),
                rng.uniform(0.01, 0.1),
                rng.uniform(-1, 1, 3),
                rng.uniform(-1, 1, 3) * rng.integers(0, 2),
            )
        )
    return Movers(0.0, movers)


def some_aim(targets: list[Target], rng) -> Aim:
    """One target or more, of whichever end effectors."""
    kept = rng.integers(0, len(targets))
    return Aim(
        tuple(
            target if k == kept or rng.random() < 0.7 else None
            for k, target in enumerate(targets)
        )
    )


def some_target(X_WE, X_WT, rng) -> Target:
    """A plain target half the time; else with a line, weights or a way on."""
    target = Target(X_WT)
    if rng.random() < 0.5:
        return target
    if rng.random() < 0.5:
        weights = rng.choice([0.0, 0.2, 1.0, 5.0], 6)
        if np.count_nonzero(weights[:3]) == 1:
            weights[:3] = 0.0
        if weights.any():
            target = dc.replace(target, weights=weights)
    if rng.random() < 0.5:
        X_WA = X_WE.copy()
        X_WA[:3, 3] += rng.normal(size=3) * rng.choice([0, 0.01, 1])
        target = dc.replace(target, line=Line(X_WA, 0.1))
    if rng.random() < 0.5:
        target = dc.replace(target, passed_within=0.05, onward=0.7)
    return target


def some_guidance(robot, q, rng) -> Guidance:
    path = None
    if rng.random() < 0.5:
        steps = rng.normal(size=(rng.integers(1, 5), robot.n_q)) * 0.1
        if robot.n_base:  # Now the base only turns, now it drives.
            steps[rng.random(len(steps)) < 0.5, :2] = 0.0
        path = Path.through(q + np.cumsum(steps, axis=0) - steps[0])
        k = len(path.s)
        if k > 1 and rng.random() < 0.7:
            v = rng.uniform(0, 2, k) * (rng.random(k) < 0.7)
            path = dc.replace(path, v=v, a=rng.uniform(0, 20, (k, 2)))

    def maybe(value):
        return value if rng.random() < 0.5 else None

    return Guidance(
        "some",
        float(rng.choice([-1.0, 0.0, 1.0])),
        float(rng.normal()),
        float(rng.choice([0.0, 0.5, 1.0])),
        maybe(0.013),
        path,
        maybe(3.0),
        maybe(0.004),
        float(rng.choice([1.0, 2.0])),
    )
