"""Devices on which a splat can be reconstructed."""

import importlib.util

from remosplat_drake.base.errors import (
    FieldError,
    MissingExtraError,
    RemoSplatError,
    unknown_name,
)

AUTO, CUDA, CPU, NONE = "auto", "cuda", "cpu", "none"
"""Devices: the best available; training on a GPU; refinement on the CPU;
surfels without refinement."""

DEVICES = (AUTO, CUDA, CPU, NONE)
"""All devices that a user may name."""

_TRAINING = ("torch", "gsplat", "pytorch_msssim")
"""Packages that training needs, of the extra `gpu`."""


def choose_device(name: str) -> str:
    """Returns the named device; for `AUTO`, the best that is available.

    Raises:
        FieldError: There is no such name.
        MissingExtraError: Training is requested and torch is not installed.
        RemoSplatError: Training is requested and there is no CUDA device.
    """
    if name not in DEVICES:
        raise FieldError(
            "reconstruct", "--device", unknown_name("device", name, DEVICES)
        )
    if name in (CPU, NONE):
        return name
    has_torch = all(map(importlib.util.find_spec, _TRAINING))
    if has_torch:
        import torch

        if torch.cuda.is_available():
            return CUDA
    if name == AUTO:
        return CPU
    if not has_torch:
        raise MissingExtraError("training a splat", "gpu")
    raise RemoSplatError(
        "training a splat needs a CUDA device; with --device cpu, the splat is"
        " refined but not trained"
    )
