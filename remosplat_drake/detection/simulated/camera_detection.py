"""`CameraDetection`: the system that detects movers by simulated cameras."""

import dataclasses as dc
from collections.abc import Sequence

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    State,
)

from remosplat_drake.capture.rendering.sensor_noise import (
    PRESETS,
    SensorNoise,
)
from remosplat_drake.detection.detection_camera_config import (
    DetectionCameraConfig,
)
from remosplat_drake.detection.detection_config import DetectionConfig
from remosplat_drake.detection.known_scene import KnownScene
from remosplat_drake.detection.simulated.simulated_camera import SimulatedCamera
from remosplat_drake.detection.simulated.simulated_detection import (
    PlacedCamera,
    SimulatedDetection,
)
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.scene.mover import Movers
from remosplat_drake.scene.primitive_scene import PrimitiveScene

NOISE = "realsense_d435"
"""Name of the noise model of simulated cameras."""

COLUMNS = 80
"""A row of a simulated image has at most this many pixels, which limits the
computing time.
"""


class CameraDetection(LeafSystem):
    """Detects true movers with simulated depth cameras.

    .. pydrake_system::

        name: CameraDetection
        input_ports:
        - configuration
        - truth
        - distance_field
        output_ports:
        - movers

    `configuration` is the robot's q, `truth` are the true `Movers`, and
    `distance_field` is the controller's map. An object at rest is no longer a
    mover when a version of the map contains it. At each update, every camera
    whose period has passed takes an image, with noise. `movers` are the
    detections from all images that are older than their latency.

    Args:
        detection: The cameras, and the initial state of detection.
        n_q: Length of a configuration.
        period: Time between two updates, the control period [s].
    """

    def __init__(
        self, *, detection: SimulatedDetection, n_q: int, period: float
    ):
        super().__init__()
        self.set_name("camera_detection")
        self._configuration = self.DeclareVectorInputPort("configuration", n_q)
        self._truth = self.DeclareAbstractInputPort(
            "truth", Value[object](Movers(0.0))
        )
        self._field = self.DeclareAbstractInputPort(
            "distance_field", Value[object]()
        )
        # A copy of a context has its own cameras, with independent noise.
        self._detection = self.DeclareAbstractState(Value[object](detection))
        self._known = self.DeclareAbstractState(Value[object](Movers(0.0)))
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._look)
        self.DeclareAbstractOutputPort(
            "movers",
            lambda: Value[object](Movers(0.0)),
            self._calc_movers,
            {self.abstract_state_ticket(self._known)},
        )

    def _look(self, context: Context, state: State) -> None:
        cell = state.get_mutable_abstract_state(int(self._detection))
        q = np.array(self._configuration.Eval(context))
        truth = self._truth.Eval(context)
        detection: SimulatedDetection = cell.get_mutable_value()
        detection.learn(self._field.Eval(context))
        movers = detection.at(context.get_time(), q, truth)
        known = state.get_mutable_abstract_state(int(self._known))
        known.set_value(movers)

    def _calc_movers(self, context: Context, output: AbstractValue) -> None:
        known = context.get_abstract_state(int(self._known))
        output.set_value(known.get_value())

    @staticmethod
    def AddToBuilder(
        builder: DiagramBuilder,
        *,
        detection: SimulatedDetection,
        configuration: OutputPort,
        truth: OutputPort,
        distance_field: OutputPort,
        period: float,
    ) -> "CameraDetection":
        """Adds the system, and connects its inputs.

        Args:
            builder: The builder of the diagram.
            detection: The cameras, and the initial state of detection.
            configuration: The output port of the robot's q.
            truth: The output port of the true `Movers`.
            distance_field: The output port of the map's `DistanceField`.
            period: Time between two updates [s].
        """
        system = builder.AddSystem(
            CameraDetection(
                detection=detection, n_q=configuration.size(), period=period
            )
        )
        builder.Connect(configuration, system.GetInputPort("configuration"))
        builder.Connect(truth, system.GetInputPort("truth"))
        builder.Connect(distance_field, system.GetInputPort("distance_field"))
        return system


def simulated_detection(
    cameras: Sequence[DetectionCameraConfig],
    robot: RobotModel,
    truth: PrimitiveScene | None,
    known: KnownScene,
    config: DetectionConfig,
    seed: int,
) -> SimulatedDetection:
    """Makes the simulated cameras of a scenario.

    Args:
        cameras: The cameras. Images wider than `COLUMNS` are shrunk to this
            width.
        robot: The robot, which occludes objects and may carry cameras.
        truth: The static scene; None for an empty one.
        known: The map.
        config: Settings, with errors, margins and bounds.
        seed: Seed of the cameras' noise.

    Raises:
        RemoSplatError: A camera is on no frame of the robot.
    """
    placed = placed_cameras(cameras, robot, truth, seed)
    return SimulatedDetection(placed, robot, known, config)


def placed_cameras(
    cameras: Sequence[DetectionCameraConfig],
    robot: RobotModel,
    truth: PrimitiveScene | None,
    seed: int,
) -> list[PlacedCamera]:
    """Places the simulated cameras of a scenario.

    Args:
        cameras: The cameras. Images wider than `COLUMNS` are shrunk to this
            width.
        robot: The robot, which may carry cameras.
        truth: The static scene; None for an empty one.
        seed: Seed of the cameras' noise.

    Raises:
        RemoSplatError: A camera is on no frame of the robot.
    """
    return [
        PlacedCamera(
            _small(camera, truth, seed + i),
            camera.pose(robot),
            1 / camera.rate,
            camera.latency,
        )
        for i, camera in enumerate(cameras)
    ]


def coarse_noise(share: float) -> SensorNoise:
    """Returns the noise of a downsampled image.

    The noise model contains the errors at outlines in pixels of the large
    image. They are converted to pixels of the small image.

    Args:
        share: Ratio of the small image's width to the large image's width.
    """
    noise = PRESETS[NOISE]
    return dc.replace(
        noise,
        outline_jitter=share * noise.outline_jitter,
        outline_loss=share * noise.outline_loss,
    )


def _small(
    config: DetectionCameraConfig, truth: PrimitiveScene | None, seed: int
) -> SimulatedCamera:
    share = min(1.0, COLUMNS / config.width)
    size = max(1, round(share * config.height)), round(share * config.width)
    scale = [size[1] / config.width, size[0] / config.height, 1.0]
    return SimulatedCamera(
        config.name,
        np.diag(scale) @ config.K,
        size,
        truth,
        coarse_noise(share),
        seed,
        config.max_depth,
    )
