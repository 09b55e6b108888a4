"""Space that a map takes for free because the robot is there."""

import dataclasses as dc

import numpy as np
from mapped_table import looking_around, make_job, table_world

from remosplat_drake.mapping.known_space import space_around
from remosplat_drake.mapping.mapping_config import MappingConfig
from remosplat_drake.mapping.mapping_job import free_around
from remosplat_drake.oracle.unknown_space import unknown_space_field
from remosplat_drake.signals.coverage import with_free


def test_the_space_around_the_start_stays_free(tmp_path):
    """As it was before the first map: nothing shrinks around the robot."""
    config, table = MappingConfig(), table_world()
    job = make_job(table, tmp_path / "session", config)
    nothing = space_around(table.robot.spheres_at(table.q0), config)
    before = unknown_space_field(nothing)
    unseen = dc.replace(nothing, state=np.zeros_like(nothing.state))
    places = np.array(looking_around(table, 2))
    free = with_free(unseen, free_around(job, places), config.robot_margin)
    after = unknown_space_field(free)
    for q in (table.q0, *places):
        spheres = table.robot.spheres_at(q)
        now = after.clearances(spheres).minimum()
        assert now >= before.clearances(spheres).minimum()
        assert now >= config.robot_margin - 1e-9
