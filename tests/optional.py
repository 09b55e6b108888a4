"""Marks of tests that need what a plain installation does not have."""

from importlib.util import find_spec

import pytest

HAS_TORCH = find_spec("torch") is not None

needs_torch = pytest.mark.skipif(
    not HAS_TORCH, reason="needs torch, of the extra `gpu`"
)
