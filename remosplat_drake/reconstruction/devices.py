"""Devices on which a splat can be reconstructed."""

import importlib.util

from remosplat_drake.base.errors import (
    FieldError,
    MissingExtraError,
    RemoSplatError,
    unknown_name,
)

AUTO, CUDA, CPU, NONE = "auto", "cuda", "cpu", "none"
"""Names of devices. `AUTO` is the best available one. Training needs a GPU,
refinement runs on the CPU, and the last name stands for surfels without
refinement.
"""

DEVICES = (AUTO, CUDA, CPU, NONE)
"""All devices that a user may name."""

_TRAINING = ("torch", "gsplat", "pytorch_msssim")
"""Packages of the extra `gpu` that training needs."""


def choose_device(name: str) -> str:
    """Checks the name of a device; replaces `AUTO` by the best device.

    Raises:
        FieldError: The name is not in `DEVICES`.
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
        "training a splat needs a CUDA device, and none was found; use "
        "--device cpu to refine the splat without training"
    )
