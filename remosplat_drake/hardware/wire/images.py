"""Encodes and decodes camera images in LCM messages (lcmt_image_array).

The format is that of Drake's `ImageToLcmImageArrayT`. Drake's own systems are
not used to read images, since they raise an exception after a malformed image.
"""

import dataclasses as dc
import zlib

import numpy as np
from drake import lcmt_image, lcmt_image_array

from remosplat_drake.hardware.wire.packets import (
    BrokenMessage,
    decode,
    from_utime,
)

_MAX_SIDE = 8192
"""Greatest width and height of an image [pixels]."""

_MOST_MILLIMETRES = 65_535
"""Greatest depth that two bytes can represent [mm]."""

_SAVED = 1
"""Compression level of zlib. Higher levels take longer than the time between
two images.
"""

_COLOR_CHANNELS = {lcmt_image.PIXEL_FORMAT_RGBA: 4}
_COLOR_CHANNELS[lcmt_image.PIXEL_FORMAT_RGB] = 3

_DEPTH_TYPES = {
    lcmt_image.CHANNEL_TYPE_FLOAT32: (np.dtype("<f4"), 1.0),
    lcmt_image.CHANNEL_TYPE_UINT16: (np.dtype("<u2"), 1e-3),
}
"""NumPy's type of depths and their unit [m], keyed by LCM's type of channel."""


@dc.dataclass(frozen=True, eq=False)
class CameraImages:
    """Images of a camera's driver; a copy is the object itself.

    Attributes:
        rgb: Colours, shape (h, w, 3), uint8.
        depth: Depth z in the camera frame, shape (h, w), float32 [m]; 0 and
            inf are beyond the camera's range.
        stamp: Time at which the images were taken, by the driver's wall clock
            [s].
    """

    rgb: np.ndarray
    depth: np.ndarray
    stamp: float

    def __deepcopy__(self, memo) -> "CameraImages":
        return self


def encode_images(rgb: np.ndarray, depth: np.ndarray, utime: int) -> bytes:
    """Encodes a colour and a depth image, compressed without loss.

    Args:
        rgb: Colours, shape (h, w, 3), uint8.
        depth: Depth z, shape (h, w) [m].
        utime: Stamp of both images: wall clock of the Unix epoch [us].
    """
    message = lcmt_image_array()
    message.header.utime = utime
    alpha = np.full((*rgb.shape[:2], 1), 255, np.uint8)
    message.images = [
        _encoded(
            np.concatenate([rgb, alpha], axis=2),
            lcmt_image.PIXEL_FORMAT_RGBA,
            lcmt_image.CHANNEL_TYPE_UINT8,
        ),
        _encoded(
            depth.astype("<f4"),
            lcmt_image.PIXEL_FORMAT_DEPTH,
            lcmt_image.CHANNEL_TYPE_FLOAT32,
        ),
    ]
    for image in message.images:
        image.header.utime = utime
    message.num_images = len(message.images)
    return message.encode()


def encode_depth(depth: np.ndarray, utime: int) -> bytes:
    """Encodes a depth image alone, in millimetres, as sensors measure it.

    Args:
        depth: Depth z, shape (h, w) [m]; 0 where unknown. Depths beyond 65 m,
            including inf, are sent as 65 m.
        utime: Stamp: wall clock of the Unix epoch [us].
    """
    steps = np.rint(1e3 * np.minimum(depth, 1e-3 * _MOST_MILLIMETRES))
    steps = steps.astype("<u2")
    message = lcmt_image_array()
    message.header.utime = utime
    message.images = [
        _encoded(
            steps,
            lcmt_image.PIXEL_FORMAT_DEPTH,
            lcmt_image.CHANNEL_TYPE_UINT16,
        )
    ]
    message.images[0].header.utime = utime
    message.num_images = 1
    return message.encode()


def _encoded(pixels: np.ndarray, pixel_format: int, channel_type: int):
    image = lcmt_image()
    image.height, image.width = pixels.shape[:2]
    image.row_stride = pixels.strides[0]
    image.pixel_format, image.channel_type = pixel_format, channel_type
    image.compression_method = lcmt_image.COMPRESSION_METHOD_ZLIB
    image.data = zlib.compress(pixels.tobytes(), _SAVED)
    image.size = len(image.data)
    return image


def decode_images(data: bytes) -> CameraImages:
    """Decodes and checks a message of a camera.

    Args:
        data: The encoded packet.

    Raises:
        BrokenMessage: The packet does not contain a colour image and a depth
            image of the same size.
    """
    message = decode(lcmt_image_array, data)
    rgb = depth = None
    for image in message.images:
        if image.pixel_format in _COLOR_CHANNELS:
            rgb = _color(image)
        elif image.pixel_format == lcmt_image.PIXEL_FORMAT_DEPTH:
            depth = _depth(image)
    if rgb is None or depth is None:
        missing = "colour" if rgb is None else "depth"
        raise BrokenMessage(f"holds no {missing} image")
    if rgb.shape[:2] != depth.shape:
        raise BrokenMessage("contains colours and depths of different sizes")
    return CameraImages(rgb, depth, from_utime(message.header.utime))


def decode_depth(data: bytes) -> tuple[np.ndarray, float]:
    """Decodes and checks the depth image in a message of a camera.

    Args:
        data: The encoded packet; colours in it are ignored.

    Returns:
        Depth z, shape (h, w), float32 [m], and the time at which the image was
        taken, by the driver's wall clock [s]. Depths of 0 and inf are outside
        the camera's range.

    Raises:
        BrokenMessage: The packet contains no depth image.
    """
    message = decode(lcmt_image_array, data)
    for image in message.images:
        if image.pixel_format == lcmt_image.PIXEL_FORMAT_DEPTH:
            return _depth(image), from_utime(message.header.utime)
    raise BrokenMessage("holds no depth image")


def _color(image: lcmt_image) -> np.ndarray:
    if image.channel_type != lcmt_image.CHANNEL_TYPE_UINT8:
        raise BrokenMessage(f"contains colours of type {image.channel_type}")
    channels = _COLOR_CHANNELS[image.pixel_format]
    return _pixels(image, np.dtype(np.uint8), channels)[..., :3]


def _depth(image: lcmt_image) -> np.ndarray:
    if image.channel_type not in _DEPTH_TYPES:
        raise BrokenMessage(f"contains depths of type {image.channel_type}")
    dtype, unit = _DEPTH_TYPES[image.channel_type]
    steps = _pixels(image, dtype, 1)[..., 0]
    return np.ascontiguousarray(steps * np.float32(unit), np.float32)


def _pixels(image: lcmt_image, dtype: np.dtype, channels: int) -> np.ndarray:
    """Decodes the pixels of an image, shape (h, w, channels)."""
    shape = image.height, image.width, channels
    if not all(0 < side <= _MAX_SIDE for side in shape):
        raise BrokenMessage(
            f"has {image.width} x {image.height} pixels; valid: 1 to"
            f" {_MAX_SIDE} each"
        )
    if image.bigendian:
        dtype = dtype.newbyteorder(">")
    size = int(np.prod(shape)) * dtype.itemsize
    if image.row_stride * image.height != size:
        raise BrokenMessage(
            f"has rows of {image.row_stride} bytes, not {size // image.height}"
        )
    raw = _uncompressed(image, size)
    if len(raw) != size:
        raise BrokenMessage(f"has {len(raw)} bytes of pixels, not {size}")
    return np.frombuffer(raw, dtype).reshape(shape)


def _uncompressed(image: lcmt_image, size: int) -> bytes:
    """Decompresses an image's pixels, up to slightly more than `size`."""
    method = image.compression_method
    if method == lcmt_image.COMPRESSION_METHOD_NOT_COMPRESSED:
        return image.data
    if method != lcmt_image.COMPRESSION_METHOD_ZLIB:
        raise BrokenMessage(f"is compressed by method {method}; valid: 0, 1")
    try:
        return zlib.decompressobj().decompress(image.data, size + 1)
    except zlib.error as error:
        raise BrokenMessage(f"cannot be decompressed: {error}") from error
