"""Reads selected fields of YAML that other programs write, with line numbers.

This module ignores unknown fields, and raises an error if a required field is
missing. In contrast, `strict_yaml`, which reads the files of this package,
rejects unknown fields.
"""

import typing
from pathlib import Path

import numpy as np
import yaml

from remosplat_drake.base.ranges import joined
from remosplat_drake.base.yaml_nodes import (
    compose,
    fail,
    fields,
    is_null,
    read_text,
    scalar,
)


class ForeignValue:
    """A value in a YAML file, with its line and its path in the YAML document.

    Attributes:
        field: Path of the value inside its YAML document; empty for the whole
            document.
    """

    def __init__(self, node: yaml.Node, field: str = ""):
        self._node = node
        self.field = field

    @staticmethod
    def read(path: Path) -> "ForeignValue":
        """Reads a file, and returns its whole YAML document.

        Raises:
            FileError: The file is missing or not YAML.
        """
        return ForeignValue(compose(read_text(path), str(path)))

    def find(self, name: str) -> "ForeignValue | None":
        """Returns a field of a mapping; None if it is absent or null.

        Raises:
            FieldError: This is not a mapping.
        """
        _, node = fields(self._node, self.field).get(name, (None, None))
        if node is None or is_null(node):
            return None
        return ForeignValue(node, joined(self.field, name))

    def get(self, name: str) -> "ForeignValue":
        """Returns a required field of a mapping.

        Raises:
            FieldError: This is not a mapping, or the field is missing.
        """
        found = self.find(name)
        if found is None:
            fail(self._node, joined(self.field, name), "is missing")
        return found

    def items(self) -> list["ForeignValue"]:
        """Returns the entries of a list.

        Raises:
            FieldError: This is not a list.
        """
        if not isinstance(self._node, yaml.SequenceNode):
            self.fail("expected a list")
        return [
            ForeignValue(node, f"{self.field}[{i}]")
            for i, node in enumerate(self._node.value)
        ]

    def text(self) -> str:
        """Returns a string.

        Raises:
            FieldError: This is not a string.
        """
        if not isinstance(self._node, yaml.ScalarNode):
            self.fail("expected a text")
        return self._node.value

    def number(self) -> float:
        """Returns a finite number.

        Raises:
            FieldError: This is not a finite number.
        """
        value = None
        if isinstance(self._node, yaml.ScalarNode):
            value = scalar(self._node, float, self.field)
        if value is None or not np.isfinite(value):
            self.fail("expected a finite number")
        return value

    def numbers(self, count: int | None = None) -> np.ndarray:
        """Returns a list of finite numbers.

        Args:
            count: Required length; None accepts any.

        Raises:
            FieldError: This is not a list of finite numbers, or it has another
                length.
        """
        values = [item.number() for item in self.items()]
        if count is not None and len(values) != count:
            self.fail(f"expected {count} numbers, got {len(values)}")
        return np.array(values, float)

    def fail(self, problem: str) -> typing.NoReturn:
        """Raises a `FieldError` that names file, line and field."""
        fail(self._node, self.field, problem)
