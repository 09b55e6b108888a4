"""A live map whose distances a GPU measures: it swaps as the CPU's does."""

import numpy as np
import pytest
from map_station import Station
from mapped_table import make_job, table_world

from remosplat_drake.mapping.mapping_process import MappingProcess
from remosplat_drake.oracle.backend import missing_for_cuda
from remosplat_drake.oracle.cuda.depth_rasterization import CudaDepthField
from remosplat_drake.oracle.cuda.sphere_to_ellipsoid import (
    CudaSphereToEllipsoidField,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    SphereToEllipsoid,
)
from remosplat_drake.oracle.sphere_to_ellipsoid import SphereToEllipsoidField

pytestmark = pytest.mark.gpu

REACH = 0.5


@pytest.mark.usefixtures("rendering")
@pytest.mark.parametrize(
    ("oracle", "kind", "on_cpu"),
    [
        (
            SphereToEllipsoid(backend="cuda"),
            CudaSphereToEllipsoidField,
            SphereToEllipsoidField,
        ),
        (
            DepthRasterization(backend="cuda"),
            CudaDepthField,
            DepthRasterizationField,
        ),
    ],
)
def test_maps_are_swapped(tmp_path, oracle, kind, on_cpu):
    problem = missing_for_cuda()
    if problem:
        pytest.skip(f"the CUDA backend {problem}")
    table = table_world()
    job = make_job(table, tmp_path / "session", oracle=oracle)
    process = MappingProcess(job)
    station = Station(table, process)
    spheres = table.robot.spheres_at(table.q0)
    first = None
    for version in (1, 2):
        station.scan()
        station.until_quiet()
        assert station.status.trouble == ""
        scene_map = station.status.scene_map
        assert scene_map.version == version
        field = station.asked_field
        assert field is scene_map.field and isinstance(field, kind)
        answer = field.clearances(spheres, REACH)
        expected = on_cpu(scene_map.splat_W).clearances(spheres, REACH)
        assert len(expected) > 0
        np.testing.assert_array_equal(answer.sphere, expected.sphere)
        np.testing.assert_allclose(
            answer.distance, expected.distance, atol=1e-5
        )
        first = first or (field, answer)
    # The field that was swapped out still answers, and the same.
    again = first[0].clearances(spheres, REACH)
    np.testing.assert_array_equal(again.distance, first[1].distance)
    process.close()
