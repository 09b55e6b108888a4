"""The wrist camera's images, over the wire and out of the station's ports."""

import time

import numpy as np
import pytest
from drake import lcmt_image_array
from patience import PATIENCE
from pydrake.common.value import Value
from pydrake.lcm import DrakeLcm
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.lcm import LcmPublisherSystem
from pydrake.systems.primitives import ConstantValueSource
from pydrake.systems.sensors import (
    ImageDepth32F,
    ImageRgba8U,
    ImageToLcmImageArrayT,
    PixelType,
)

from remosplat_drake.acceptance.hardware_processes import free_url
from remosplat_drake.camera.wrist_camera_config import WristCameraConfig
from remosplat_drake.hardware.client.hardware_station import HardwareStation
from remosplat_drake.hardware.hardware_config import HardwareConfig, beside
from remosplat_drake.hardware.wire import channels


def publisher(url: str, rgb: ImageRgba8U, depth: ImageDepth32F) -> Diagram:
    """A camera's driver, which sends its images when it is told to publish."""
    builder = DiagramBuilder()
    images = builder.AddSystem(ImageToLcmImageArrayT(do_compress=True))
    for name, pixel, image in (
        ("rgb", PixelType.kRgba8U, rgb),
        ("depth", PixelType.kDepth32F, depth),
    ):
        source = builder.AddSystem(ConstantValueSource(Value(image)))
        builder.Connect(
            source.get_output_port(),
            images.DeclareImageInputPort[pixel](name=name),
        )
    sender = builder.AddSystem(
        LcmPublisherSystem.Make(
            channels.WRIST_CAMERA,
            lcmt_image_array,
            DrakeLcm(url),
            use_cpp_serializer=True,
        )
    )
    builder.Connect(
        images.image_array_t_msg_output_port(), sender.get_input_port()
    )
    return builder.Build()


def test_images_arrive_as_the_simulated_camera_has_them(frankie):
    url = free_url()
    station = HardwareStation(
        config=HardwareConfig(lcm_url=url),
        robot=frankie,
        wrist_camera=WristCameraConfig(width=4, height=3),
    )
    simulator = Simulator(station)
    simulator.Initialize()
    rgb, depth = ImageRgba8U(4, 3), ImageDepth32F(4, 3)
    rgb.mutable_data[:] = np.arange(48).reshape(3, 4, 4)
    depth.mutable_data[..., 0] = 0.1 * np.arange(12).reshape(3, 4)
    driver = publisher(beside(url), rgb, depth)
    sending = driver.CreateDefaultContext()
    deadline = time.monotonic() + PATIENCE
    context = simulator.get_context()
    color = station.GetOutputPort("wrist_camera.rgb")
    while color.Eval(context).width() == 0:
        assert time.monotonic() < deadline
        driver.ForcedPublish(sending)
        time.sleep(0.01)
        station.receive(simulator.get_mutable_context())
    np.testing.assert_array_equal(
        color.Eval(context).data[..., :3], rgb.data[..., :3]
    )
    seen = station.GetOutputPort("wrist_camera.depth").Eval(context).data
    assert seen == pytest.approx(depth.data)
    break_the_camera(station, simulator, url)
    assert station.GetOutputPort("wrist_camera.depth").Eval(context).data == (
        pytest.approx(depth.data)
    )


def break_the_camera(station, simulator, url: str) -> None:
    """Sends nonsense until the station has counted some."""
    lcm, decoder = DrakeLcm(beside(url)), station.camera.decoder
    end = time.monotonic() + PATIENCE
    while not decoder.broken:
        assert time.monotonic() < end
        lcm.Publish(channels.WRIST_CAMERA, b"nonsense")
        station.receive(simulator.get_mutable_context())
        station.GetOutputPort("wrist_camera.rgb").Eval(simulator.get_context())
    assert decoder.problem == ("WRIST_CAMERA: is not a whole lcmt_image_array")
