"""Images on the wire, whole and broken."""

import zlib

import numpy as np
import pytest
from drake import lcmt_image, lcmt_image_array
from hypothesis import given
from hypothesis import strategies as st

from remosplat_drake.hardware.wire.images import decode_images, encode_images
from remosplat_drake.hardware.wire.packets import BrokenMessage

RGB = np.arange(60, dtype=np.uint8).reshape(4, 5, 3)
DEPTH = np.linspace(0, 2, 20, dtype=np.float32).reshape(4, 5)
PACKET = encode_images(RGB, DEPTH, 1_500_000)


def test_what_is_sent_arrives():
    images = decode_images(PACKET)
    np.testing.assert_array_equal(images.rgb, RGB)
    np.testing.assert_array_equal(images.depth, DEPTH)
    assert images.stamp == 1.5


def test_depths_may_come_in_millimetres():
    message = lcmt_image_array.decode(PACKET)
    depth = message.images[1]
    depth.channel_type = lcmt_image.CHANNEL_TYPE_UINT16
    depth.compression_method = lcmt_image.COMPRESSION_METHOD_NOT_COMPRESSED
    depth.row_stride, depth.size = 10, 40
    depth.data = np.full((4, 5), 1234, "<u2").tobytes()
    images = decode_images(message.encode())
    np.testing.assert_allclose(images.depth, 1.234, rtol=1e-6)


BREAKS = {
    "no depth image": lambda m: keep(m, m.images[:1]),
    "no colour image": lambda m: keep(m, m.images[1:]),
    "0 x 4 pixels": lambda m: change(m, 0, width=0),
    "rows of 3 bytes": lambda m: change(m, 1, row_stride=3),
    "cannot be decompressed": lambda m: change(m, 1, data=b"nonsense", size=8),
    "has 1 bytes of pixels": lambda m: change(
        m, 1, data=zlib.compress(b"x"), size=len(zlib.compress(b"x"))
    ),
    "method 2": lambda m: change(m, 0, compression_method=2),
    "colours of type 6": lambda m: change(m, 0, channel_type=6),
    "depths of type 1": lambda m: change(m, 1, channel_type=1),
}


def keep(message, images):
    message.images, message.num_images = images, len(images)


def change(message, index, **fields):
    for name, value in fields.items():
        setattr(message.images[index], name, value)


@pytest.mark.parametrize("problem", sorted(BREAKS))
def test_a_broken_image_is_named(problem):
    message = lcmt_image_array.decode(PACKET)
    BREAKS[problem](message)
    with pytest.raises(BrokenMessage, match=problem):
        decode_images(message.encode())


@given(st.integers(0, len(PACKET) - 1), st.integers(0, 255), st.booleans())
def test_nothing_but_a_broken_message_comes_of_garbage(at, byte, cut):
    packet = bytearray(PACKET)
    packet[at] = byte
    if cut:
        del packet[at:]
    try:
        images = decode_images(bytes(packet))
    except BrokenMessage:
        return
    assert images.rgb.shape[:2] == images.depth.shape
