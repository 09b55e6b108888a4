"""The committed Python is what lcm-gen makes of the committed types."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import remosplat_drake.hardware.wire.messages
from remosplat_drake.hardware.wire.messages.base_command import base_command
from remosplat_drake.hardware.wire.messages.base_status import base_status

MESSAGES = Path(remosplat_drake.hardware.wire.messages.__file__).parent
TYPES = sorted(path.stem for path in MESSAGES.glob("*.lcm"))


@pytest.fixture(scope="module")
def generated(tmp_path_factory) -> Path:
    lcm_gen = shutil.which("lcm-gen", path=str(Path(sys.executable).parent))
    if lcm_gen is None:
        pytest.skip("lcm-gen is not installed (development group)")
    folder = tmp_path_factory.mktemp("messages")
    sources = [MESSAGES / f"{name}.lcm" for name in TYPES]
    subprocess.run([lcm_gen, "-p", "--ppath", folder, *sources], check=True)
    return folder


@pytest.mark.parametrize("name", TYPES)
def test_python_is_up_to_date(generated, name):
    made = (generated / f"{name}.py").read_text()
    assert (MESSAGES / f"{name}.py").read_text() == made


def test_base_command_survives_the_wire():
    message = base_command()
    message.utime = 1_700_000_000_123_456
    message.forward, message.left, message.yaw_rate = 0.25, 0.125, -0.5
    copy = base_command.decode(message.encode())
    assert copy.utime == 1_700_000_000_123_456
    assert (copy.forward, copy.left, copy.yaw_rate) == (0.25, 0.125, -0.5)
    assert len(message.encode()) == 8 + 8 + 8 + 8 + 8


def test_base_status_survives_the_wire():
    message = base_status()
    message.pose = [1.0, -2.0, 0.5]
    message.mode = base_status.FAULT
    message.protective_stop = 1
    message.battery = 0.75
    copy = base_status.decode(message.encode())
    assert list(copy.pose) == [1.0, -2.0, 0.5]
    assert (copy.mode, copy.protective_stop) == (base_status.FAULT, 1)
    assert (copy.emergency_stop, copy.battery) == (0, 0.75)


def test_types_are_told_apart():
    with pytest.raises(ValueError, match="Decode error"):
        base_status.decode(base_command().encode())
