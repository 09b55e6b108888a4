"""Movers of a scene are drawn by its name, within the stated bounds."""

from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.generation.moving_scenes import (
    FASTEST,
    MOST_MOVERS,
    START_ROOM,
    draw_movers,
)
from remosplat_drake.generation.scene_generators import generate
from remosplat_drake.scene.moving.person import Person
from remosplat_drake.scene.moving.track import movers_at

SCENES = [(family, seed) for family in ("table", "posts") for seed in range(5)]


@pytest.mark.parametrize(("family", "seed"), SCENES)
def test_they_keep_what_is_said_of_them(family, seed):
    scene = generate(family, seed)
    assert scene.X_WE_target is not None and scene.X_WB_start is not None
    drawn = draw_movers(scene, seed)
    assert repr(drawn) == repr(draw_movers(scene, seed))
    assert 1 <= len(drawn) <= MOST_MOVERS
    goal = scene.X_WE_target.translation()[:2]
    for config in drawn:
        track = config.make(Path())
        for mover in track.movers(0.0):
            start = mover.X_WM.translation()[:2] - scene.X_WB_start[:2]
            assert np.linalg.norm(start) > 0.7 * START_ROOM
        for time in np.linspace(0.0, 20.0, 80):
            parts = track.movers(time)
            body = parts[0]
            assert np.linalg.norm(body.v_WM) <= 1.1 * FASTEST
            assert np.linalg.norm(body.v_WM) <= body.max_speed
        # In the end no mover is where the hand goes, nor where the base stands.
        for mover in movers_at([track], 1e4):
            p_WM = mover.X_WM.translation()[:2]
            assert np.linalg.norm(p_WM - goal) > 0.6
            assert np.linalg.norm(p_WM - scene.X_WB_start[:2]) > 0.6


def test_told_bounds_hold():
    """A track that is told none has its own; none is told too little."""
    for seed in range(6):
        for config in draw_movers(generate("table", seed), seed):
            if isinstance(config, Person):
                continue
            own = type(config)(
                **{**vars(config), "max_speed": None, "max_acceleration": None}
            )
            (true,), (told,) = (
                c.make(Path()).movers(0.0) for c in (own, config)
            )
            assert true.max_speed <= told.max_speed
            assert true.max_acceleration <= told.max_acceleration


def test_names_and_seeds_matter():
    scene = generate("table", 1)
    assert repr(draw_movers(scene, 1)) != repr(draw_movers(scene, 2))
    other = generate("table", 2)
    assert repr(draw_movers(scene, 1)) != repr(draw_movers(other, 1))
