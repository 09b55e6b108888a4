"""The backend that answers: the choice and its errors, on any CPU."""

import subprocess
import sys

import numpy as np
import pytest

from remosplat_drake.base.errors import FieldError, RemoSplatError
from remosplat_drake.oracle import backend
from remosplat_drake.oracle.backend import choose_backend
from remosplat_drake.oracle.cuda.depth_rasterization import (
    CudaDepthField,
    check_sensor,
)
from remosplat_drake.oracle.cuda.sphere_to_ellipsoid import (
    CudaSphereToEllipsoidField,
)
from remosplat_drake.oracle.depth_rasterization import DepthRasterizationField
from remosplat_drake.oracle.depth_rasterization_gsplat import GsplatDepthField
from remosplat_drake.oracle.depth_sensor import DepthSensor
from remosplat_drake.oracle.oracle_config import (
    DepthRasterization,
    SphereToEllipsoid,
    make_field,
)
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def _splat(n_scales: int = 2) -> GaussianSplat:
    return GaussianSplat(
        np.array([[0.5, 0, 0]]),
        np.array([[1.0, 0, 0, 0]]),
        np.full((1, n_scales), 0.1),
        np.array([0.9]),
        np.zeros((1, 3)),
    )


@pytest.fixture
def without_torch(monkeypatch):
    monkeypatch.setattr(backend, "find_spec", lambda name: None)


@pytest.fixture
def with_cuda(monkeypatch):
    monkeypatch.setattr(backend, "missing_for_cuda", lambda: "")


def _choose(asked: str) -> str:
    return choose_backend(asked, "s.yaml:S", "oracle.backend")


def test_auto_takes_what_is_there(with_cuda):
    assert [_choose(b) for b in ("auto", "cpu", "cuda")] == [
        "cuda",
        "cpu",
        "cuda",
    ]


def test_auto_takes_the_cpu_without_torch(without_torch):
    assert _choose("auto") == "cpu"
    assert _choose("cpu") == "cpu"


@pytest.mark.parametrize("kind", [SphereToEllipsoid, DepthRasterization])
def test_cuda_without_torch_names_the_extra(without_torch, kind):
    config = kind(backend="cuda")
    with pytest.raises(FieldError) as error:
        make_field(config, _splat(), None, "s.yaml:S")
    assert str(error.value) == (
        "s.yaml:S: oracle.backend: the cuda backend needs torch: pip install "
        "'remosplat-drake[gpu]'; use cpu or auto"
    )


def test_an_unknown_backend():
    with pytest.raises(FieldError, match="did you mean 'cuda'"):
        _choose("cuda1")


def test_the_default_is_the_cpu():
    field = make_field(DepthRasterization(), _splat(), None, "s.yaml:S")
    assert isinstance(field, DepthRasterizationField)


@pytest.mark.parametrize(
    "sensor", [DepthSensor(transmittance=0.4), DepthSensor(min_alpha=0.01)]
)
def test_gsplat_has_some_thresholds_built_in(sensor):
    with pytest.raises(FieldError, match="gsplat supports only"):
        GsplatDepthField(_splat(), sensor)


def test_the_field_itself_says_what_is_missing(without_torch):
    with pytest.raises(RemoSplatError, match="needs torch"):
        GsplatDepthField(_splat())
    with pytest.raises(RemoSplatError, match="needs torch"):
        CudaDepthField(_splat())
    with pytest.raises(RemoSplatError, match="needs torch"):
        CudaSphereToEllipsoidField(_splat())
    with pytest.raises(FieldError, match="use the cpu backend"):
        GsplatDepthField(_splat(n_scales=3))


@pytest.mark.parametrize(
    "sensor",
    [DepthSensor(low_pass_filter=True), DepthSensor(alpha_cutoff=0.9995)],
)
def test_kernels_say_what_they_cannot(sensor):
    with pytest.raises(FieldError, match="use the cpu backend"):
        check_sensor(sensor)


def test_a_solid_of_few_bisections_is_for_the_cpu(with_cuda):
    with pytest.raises(FieldError, match="bisection_steps: must be 0"):
        SphereToEllipsoid(backend="cuda", bisection_steps=3)


def test_choosing_the_cpu_loads_no_torch():
    program = (
        "import sys; from remosplat_drake.oracle.backend import *; "
        "choose_backend('cpu', '', ''); print('torch' in sys.modules)"
    )
    command = [sys.executable, "-c", program]
    answer = subprocess.run(command, capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "False"
