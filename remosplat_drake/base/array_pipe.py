"""Sends values with large arrays to another process, without blocking threads.

Pickling a whole map would copy its arrays, and block this process' other Python
threads for some milliseconds. This module writes the arrays to the pipe one by
one and without copies, while other threads continue.
"""

import dataclasses as dc
import pickle
from multiprocessing.connection import Connection
from typing import Any


@dc.dataclass(frozen=True)
class ArrayHeader:
    """The message that is sent before the arrays of a value.

    Attributes:
        body: Pickle of the value, without its arrays.
        sizes: Size of each array [bytes], in the order in which they are sent.
        read_only: Whether each array is read-only. The receiver restores this
            flag. Otherwise kernels would be compiled again for writable arrays,
            which takes half a minute.
    """

    body: bytes
    sizes: tuple[int, ...]
    read_only: tuple[bool, ...]


def send_arrays(connection: Connection, value: object) -> None:
    """Sends a value through a pipe; waits while the pipe's buffer is full.

    Args:
        connection: The sender's end of the pipe.
        value: Anything that can be pickled, such as a distance field.

    Raises:
        OSError: The other end is closed.
    """
    arrays: list[memoryview] = []

    def keep(buffer: pickle.PickleBuffer) -> None:
        arrays.append(buffer.raw())

    body = pickle.dumps(value, protocol=5, buffer_callback=keep)
    sizes = tuple(array.nbytes for array in arrays)
    read_only = tuple(array.readonly for array in arrays)
    connection.send(ArrayHeader(body, sizes, read_only))
    for array in arrays:
        connection.send_bytes(array)


def receive_arrays(connection: Connection, header: ArrayHeader) -> Any:
    """Receives a value that `send_arrays` has sent.

    Args:
        connection: The receiver's end of the pipe.
        header: The message before the arrays, which the caller has received.

    Raises:
        EOFError: The other end is closed.
    """
    arrays = [bytearray(size) for size in header.sizes]
    for array in arrays:
        connection.recv_bytes_into(array)
    buffers = [
        memoryview(array).toreadonly() if read_only else array
        for array, read_only in zip(arrays, header.read_only, strict=True)
    ]
    return pickle.loads(header.body, buffers=buffers)
