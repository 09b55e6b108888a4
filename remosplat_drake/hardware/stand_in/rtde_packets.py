"""Encodes and decodes packets of Universal Robots' RTDE, version 2.

They follow Universal Robots' guide to the Real-Time Data Exchange. A packet has
a header with its size and kind, and contains numbers in network byte order. A
recipe lists the variables of a data package.
"""

import struct
from collections.abc import Sequence
from enum import IntEnum

_HEADER = struct.Struct(">HB")

NOT_FOUND = "NOT_FOUND"
"""Type of a variable that the controller does not have."""


class Kind(IntEnum):
    """Kinds of packets, as letters."""

    REQUEST_VERSION = ord("V")
    CONTROLLER_VERSION = ord("v")
    TEXT = ord("M")
    DATA = ord("U")
    SETUP_OUTPUTS = ord("O")
    SETUP_INPUTS = ord("I")
    START = ord("S")
    PAUSE = ord("P")


_FORMATS = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
    "VECTOR6UINT32": "6I",
}
_BY_PREFIX = {
    "output_int_register": "INT32",
    "input_int_register": "INT32",
    "output_double_register": "DOUBLE",
    "input_double_register": "DOUBLE",
    "output_bit_register": "UINT32",
    "input_bit_register": "UINT32",
}
_TYPES = {
    "VECTOR6D": "target_q target_qd target_qdd target_current target_moment"
    " actual_q actual_qd actual_current actual_current_window"
    " joint_control_output actual_TCP_pose actual_TCP_speed actual_TCP_force"
    " target_TCP_pose target_TCP_speed joint_temperatures"
    " actual_joint_voltage ft_raw_wrench payload_inertia tcp_offset"
    " external_force_torque joint_position_deltas actual_current_as_torque",
    "VECTOR6INT32": "joint_mode",
    "VECTOR3D": "actual_tool_accelerometer elbow_position elbow_velocity"
    " payload_cog",
    "DOUBLE": "timestamp actual_execution_time speed_scaling"
    " target_speed_fraction actual_momentum actual_main_voltage"
    " actual_robot_voltage actual_robot_current standard_analog_input0"
    " standard_analog_input1 standard_analog_output0 standard_analog_output1"
    " speed_slider_fraction payload tcp_force_scalar collision_detection_ratio",
    "UINT64": "actual_digital_input_bits actual_digital_output_bits",
    "UINT32": "runtime_state robot_status_bits safety_status_bits"
    " analog_io_types speed_slider_mask",
    "INT32": "robot_mode safety_mode safety_status",
    "UINT8": "standard_digital_output_mask configurable_digital_output_mask"
    " standard_digital_output configurable_digital_output"
    " standard_analog_output_mask standard_analog_output_type"
    " tool_digital_output_mask tool_digital_output",
}
_BY_NAME = {
    name: kind for kind, names in _TYPES.items() for name in names.split()
}


def type_of(name: str) -> str:
    """Returns the type of a variable, or `NOT_FOUND`."""
    prefix, _, number = name.rpartition("_")
    if number.isdecimal() and prefix in _BY_PREFIX:
        return _BY_PREFIX[prefix]
    return _BY_NAME.get(name, NOT_FOUND)


class Recipe:
    """The variables of a data package, in their order.

    Attributes:
        names: Names of the variables.
        types: Types of the variables; some may be `NOT_FOUND`.
    """

    def __init__(self, names: Sequence[str]):
        """Looks up the types of the variables."""
        self.names = list(names)
        self.types = [type_of(name) for name in names]
        known = [_FORMATS[t] for t in self.types if t in _FORMATS]
        self._layout = struct.Struct(">" + "".join(known))
        self._lengths = [int(f[:-1] or 1) for f in known]

    def pack(self, values: dict[str, Sequence[float] | float]) -> bytes:
        """Encodes the values of the variables; absent values are zero."""
        numbers: list[float] = []
        for name, length in zip(self.names, self._lengths, strict=True):
            value = values.get(name, [0] * length if length > 1 else 0)
            numbers += value if isinstance(value, Sequence) else [value]
        return self._layout.pack(*numbers)

    def unpack(self, data: bytes) -> dict[str, list[float]]:
        """Decodes variables.

        Raises:
            ValueError: The length of the data does not fit the types.
        """
        try:
            numbers = list(self._layout.unpack(data))
        except struct.error as error:
            raise ValueError(str(error)) from error
        values, start = {}, 0
        for name, length in zip(self.names, self._lengths, strict=True):
            values[name] = numbers[start : start + length]
            start += length
        return values


def packet(kind: Kind, payload: bytes = b"") -> bytes:
    """Makes a packet from a header and the content."""
    return _HEADER.pack(_HEADER.size + len(payload), kind) + payload


def split(buffer: bytearray) -> list[tuple[int, bytes]]:
    """Removes complete packets from a buffer; returns kinds and payloads.

    Raises:
        ValueError: The size in a packet is less than that of its header.
    """
    found = []
    while len(buffer) >= _HEADER.size:
        size, kind = _HEADER.unpack_from(buffer)
        if size < _HEADER.size:
            raise ValueError(f"a packet of {size} bytes")
        if len(buffer) < size:
            break
        found.append((kind, bytes(buffer[_HEADER.size : size])))
        del buffer[:size]
    return found
