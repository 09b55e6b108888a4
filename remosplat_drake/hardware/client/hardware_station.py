"""`HardwareStation`: a real robot, with the ports that all stations have."""

import math

from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from remosplat_drake.hardware.client.measurement import Measurement
from remosplat_drake.hardware.client.mover_receiver import MoverReceiver
from remosplat_drake.hardware.client.remote_robot import RemoteRobot
from remosplat_drake.hardware.client.robot_link import RobotLink
from remosplat_drake.hardware.client.wrist_camera_receiver import (
    WristCameraReceiver,
)
from remosplat_drake.hardware.hardware_config import HardwareConfig
from remosplat_drake.robot.robot_model import RobotModel
from remosplat_drake.signals import station_ports as ports
from remosplat_drake.station.export import export_ports


class HardwareStation(Diagram):
    """A diagram that represents a real robot, with the ports of all stations.

    Its ports are those of `signals.station_ports`, and `movers` if the
    configuration names a process that detects moving objects. It processes the
    drivers' messages only in `receive`, and sends a command only in a forced
    publish (`ForcedPublish`). See `RemoteRobot`.

    Attributes:
        link: The LCM connection to the robot's drivers.
        camera: The system that receives the wrist camera's images; None if the
            robot has no such camera.
        movers: The system that receives movers; None if none are received.
    """

    def __init__(
        self,
        *,
        config: HardwareConfig,
        robot: RobotModel,
        wrist_camera: bool,
    ):
        """Builds the station and opens the LCM connection.

        Args:
            config: LCM URL, channels and expiry times of the drivers.
            robot: The robot; its description names the ports.
            wrist_camera: Whether the station has the wrist camera's ports.

        Raises:
            RemoSplatError: The connection cannot be opened.
        """
        super().__init__()
        self.link = RobotLink(config, robot)
        builder = DiagramBuilder()
        self._robot = builder.AddNamedSystem(
            "remote_robot",
            RemoteRobot(robot=robot, link=self.link, config=config),
        )
        self.camera, images = None, None
        if wrist_camera:
            # If images shared the socket of statuses, its buffer would
            # overflow.
            self.camera = builder.AddNamedSystem(
                "wrist_camera",
                WristCameraReceiver(
                    config.open_camera_lcm(), config.channels.wrist_camera
                ),
            )
            images = {
                ports.WRIST_CAMERA_RGB: self.camera.get_output_port(0),
                ports.WRIST_CAMERA_DEPTH: self.camera.get_output_port(1),
            }
        export_ports(builder, robot.description, [self._robot], images)
        self.movers = None
        if config.movers is not None:
            assert self.link.movers is not None
            self.movers = builder.AddNamedSystem(
                "movers",
                MoverReceiver(mailbox=self.link.movers, config=config.movers),
            )
            builder.ExportOutput(self.movers.get_output_port(), ports.MOVERS)
        builder.BuildInto(self)
        self.set_name("station")

    def newest_image(self, context: Context) -> float:
        """Returns the time of the newest image used for mover detection [s].

        Args:
            context: The station's own context.

        Returns:
            The stamp of the newest `Movers` from cameras; NaN if there are
            none.
        """
        if self.movers is None:
            return math.nan
        movers = self.GetOutputPort(ports.MOVERS).Eval(context)
        return movers.stamp if movers.cameras else math.nan

    def measurement(self, root: Context) -> Measurement:
        """Returns the measurement of the present tick.

        Args:
            root: Context of the whole diagram.
        """
        return self._robot.measurement(self._robot.GetMyContextFromRoot(root))

    def receive(self, root: Context) -> None:
        """Updates the ports with the packets that the link has received.

        Args:
            root: Context of the whole diagram, which must not be in a step.
        """
        self._robot.receive(self._robot.GetMyMutableContextFromRoot(root))
        if self.camera is not None:
            self.camera.receive(self.camera.GetMyMutableContextFromRoot(root))
        if self.movers is not None:
            self.movers.receive(self.movers.GetMyMutableContextFromRoot(root))
