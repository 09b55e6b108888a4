"""`WristCameraReceiver`: the system that receives a wrist camera's images."""

import numpy as np
from pydrake.common.value import Value
from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.framework import Context, LeafSystem
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from remosplat_drake.hardware.client.mailbox import Mailbox
from remosplat_drake.hardware.wire.images import CameraImages, decode_images
from remosplat_drake.hardware.wire.packets import BrokenMessage


class WristCameraReceiver(LeafSystem):
    """Outputs the latest images that arrived over LCM.

    .. pydrake_system::

        name: WristCameraReceiver
        output_ports:
        - color_image
        - depth_image

    `receive` stores the newest packet in the state. The packet is decoded when
    a system reads a port, so a control loop that reads no images does not wait
    for the decoding. Before the first packet, the images have no pixels. After
    a malformed packet, the previous images remain on the ports.

    Attributes:
        decoder: The decoder, which counts malformed packets.
    """

    def __init__(self, lcm: DrakeLcmInterface, channel: str):
        """Subscribes to a channel.

        Args:
            lcm: The network of the camera.
            channel: Name of the channel.
        """
        super().__init__()
        self._lcm = lcm
        self._mailbox = Mailbox(lcm, channel)
        self.decoder = ImageDecoder(channel)
        self._cell = self.DeclareAbstractState(Value(b""))
        for name, image, calc in (
            ("color_image", ImageRgba8U(), self._calc_color),
            ("depth_image", ImageDepth32F(), self._calc_depth),
        ):
            self.DeclareAbstractOutputPort(
                name,
                Value(image).Clone,
                calc,
                {self.abstract_state_ticket(self._cell)},
            )

    def receive(self, context: Context) -> None:
        """Stores the newest packet in the state.

        Args:
            context: The system's own context, between two steps.
        """
        count = self._mailbox.count
        self._lcm.HandleSubscriptions(0)
        if self._mailbox.count != count:
            value = context.get_mutable_abstract_state(int(self._cell))
            value.set_value(self._mailbox.data)

    def _images(self, context: Context) -> CameraImages | None:
        cell = context.get_abstract_state(int(self._cell))
        return self.decoder.latest(cell.get_value())

    def _calc_color(self, context: Context, output: Value) -> None:
        images = self._images(context)
        if images is not None:
            height, width = images.depth.shape
            color = ImageRgba8U(width, height)
            color.mutable_data[..., :3] = images.rgb
            color.mutable_data[..., 3] = np.uint8(255)
            output.set_value(color)

    def _calc_depth(self, context: Context, output: Value) -> None:
        images = self._images(context)
        if images is not None:
            height, width = images.depth.shape
            depth = ImageDepth32F(width, height)
            depth.mutable_data[..., 0] = images.depth
            output.set_value(depth)


class ImageDecoder:
    """Decodes packets of a camera, and counts malformed ones.

    Attributes:
        broken: Number of malformed packets so far.
        problem: Faults of the latest malformed packet, with the channel's name;
            empty before the first.
    """

    def __init__(self, channel: str):
        """Starts without an image.

        Args:
            channel: Name of the channel, which problems contain.
        """
        self._channel = channel
        self._packet = b""
        self._images: CameraImages | None = None
        self.broken = 0
        self.problem = ""

    def latest(self, packet: bytes) -> CameraImages | None:
        """Returns the latest valid images; None before the first.

        Args:
            packet: The newest packet, empty if there is none. A packet that was
                already decoded is not decoded again.
        """
        if packet and packet is not self._packet:
            self._packet = packet
            try:
                self._images = decode_images(packet)
            except BrokenMessage as error:
                self.broken += 1
                self.problem = f"{self._channel}: {error}"
        return self._images
