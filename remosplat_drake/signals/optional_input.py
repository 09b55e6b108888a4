"""Reads input ports that may be left unconnected."""

from typing import Any

from pydrake.systems.framework import Context, InputPort


def value_or_none(port: InputPort, context: Context) -> Any:
    """Returns the value of an input port, or None if it is not connected.

    Args:
        port: An input port that may be left unconnected.
        context: The context of its system.
    """
    return port.Eval(context) if port.HasValue(context) else None
