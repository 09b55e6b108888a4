"""Send a map to another process without holding up the threads of this one.

Pickling a map as it is copies its arrays, for some milliseconds in which no
other thread runs Python. Here the arrays stay where they are and are written
one by one, while the others go on.
"""

import dataclasses as dc
import pickle
from multiprocessing.connection import Connection

from remosplat_drake.signals.distance_field import DistanceField


@dc.dataclass(frozen=True)
class MapHeader:
    """What goes before the arrays of a map.

    Attributes:
        body: The field's pickle, without the arrays.
        sizes: Bytes of each array that follows.
    """

    body: bytes
    sizes: tuple[int, ...]


def send_map(connection: Connection, field: DistanceField) -> None:
    """Sends a map; waits for the reader, for a map is larger than a pipe."""
    arrays: list[memoryview] = []

    def keep(buffer: pickle.PickleBuffer) -> None:
        arrays.append(buffer.raw())

    body = pickle.dumps(field, protocol=5, buffer_callback=keep)
    sizes = tuple(array.nbytes for array in arrays)
    connection.send(MapHeader(body, sizes))
    for array in arrays:
        connection.send_bytes(array)


def receive_map(connection: Connection, header: MapHeader) -> DistanceField:
    """Receives what `send_map` has sent after the header."""
    arrays = [bytearray(size) for size in header.sizes]
    for array in arrays:
        connection.recv_bytes_into(array)
    return pickle.loads(header.body, buffers=arrays)
