"""Parsers for numbers on the command line, with one-line errors."""

import argparse
import math


def number(text: str) -> float:
    """Parses a number, which may be infinite or NaN.

    Raises:
        ArgumentTypeError: The text is not a number.
    """
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number") from None


def whole_number(text: str) -> int:
    """Parses a whole number.

    Raises:
        ArgumentTypeError: The text is not a whole number.
    """
    try:
        return int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a whole number"
        ) from None


def positive(text: str) -> float:
    """Parses a positive, finite number.

    Raises:
        ArgumentTypeError: The text is not a positive, finite number.
    """
    value = number(text)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"{text} is not a number > 0")
    return value


def not_negative(text: str) -> float:
    """Parses a finite number that is not negative.

    Raises:
        ArgumentTypeError: The text is not such a number.
    """
    value = number(text)
    if not (math.isfinite(value) and value >= 0):
        raise argparse.ArgumentTypeError(f"{text} is not a number >= 0")
    return value


def at_least_one(text: str) -> int:
    """Parses a whole number of at least one.

    Raises:
        ArgumentTypeError: The text is not such a number.
    """
    value = whole_number(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text} is not a whole number >= 1")
    return value


def port_number(text: str) -> int:
    """Parses a TCP port that a program may listen on.

    Raises:
        ArgumentTypeError: The text is no such port.
    """
    value = whole_number(text)
    if not 1024 <= value <= 65535:
        raise argparse.ArgumentTypeError(f"{text} is not 1024 to 65535")
    return value
