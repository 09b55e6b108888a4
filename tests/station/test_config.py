"""Station settings load from YAML, the station being chosen by its tag."""

import dataclasses as dc

import pytest

from remosplat_drake.base.errors import FieldError
from remosplat_drake.base.strict_yaml import load_strict
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.station.hand import SETTLING_TIME
from remosplat_drake.station.station_config import (
    MAX_STEP,
    DynamicStation,
    KinematicStation,
    kinematic_simulator_config,
)


@dc.dataclass
class Schema:
    station: KinematicStation | DynamicStation = dc.field(
        default_factory=KinematicStation
    )
    wrist_camera: WristCameraConfig | None = None


def load(tmp_path, text: str) -> Schema:
    path = tmp_path / "scenario.yaml"
    path.write_text(text)
    return load_strict(Schema, path)


def test_the_tag_chooses_the_station(tmp_path):
    schema = load(
        tmp_path,
        "station: !DynamicStation {time_step: 0.002}\n"
        "wrist_camera: {width: 64, translation: [0, 0, 0.01]}\n",
    )
    assert schema.station == DynamicStation(time_step=0.002)
    assert schema.wrist_camera is not None
    assert schema.wrist_camera.translation == [0, 0, 0.01]


def test_the_kinematic_station_is_the_default(tmp_path):
    assert load(tmp_path, "{}").station == KinematicStation()


def test_another_station_is_refused(tmp_path):
    with pytest.raises(FieldError, match="did you mean 'KinematicStation"):
        load(tmp_path, "station: !KinematicStatoin {}")


@pytest.mark.parametrize("control_period", [0.002, 0.02, 0.5])
def test_integrator_steps_fit_the_tick_and_the_gripper(control_period):
    config = kinematic_simulator_config(control_period)
    assert config.max_step_size <= min(control_period, MAX_STEP)
    # Runge-Kutta 5 is stable for steps up to 3.2 time constants.
    assert MAX_STEP <= SETTLING_TIME
    assert not config.use_error_control
