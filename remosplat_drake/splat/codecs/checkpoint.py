"""Reads and writes checkpoints of gsplat's and this package's trainers (`.pt`).

A checkpoint contains raw tensors. gsplat's 2DGS checkpoints have three scales,
too, but the trainer ignores the third. So the tensors alone do not determine
whether a checkpoint contains discs or ellipsoids.
"""

import io
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import FileError, MissingExtraError
from remosplat_drake.splat.activation import (
    checked_splat,
    exponential,
    logit,
    sigmoid,
)
from remosplat_drake.splat.codecs.unpacking import (
    ZIP_DAMAGES,
    check_count,
    check_unpacked_size,
    read_whole,
)
from remosplat_drake.splat.gaussian_splat import SH_C0, GaussianSplat
from remosplat_drake.splat.surfel_conversion import (
    is_flat,
    with_thickness,
    without_thickness,
)

_KEYS = ("means", "quats", "scales", "opacities", "sh0")
_NAME_OF_3DGS = re.compile(r"ckpt_\d+_rank\d+")
_NAME_OF_2DGS = re.compile(r"ckpt_\d+")


def read_checkpoint(path: Path, surfel: bool | None = None) -> GaussianSplat:
    """Reads the splats of a gsplat checkpoint (`.pt`, torch).

    Args:
        path: A file with the dictionary {"splats": {"means": ..., ...}, ...},
            or with the inner dictionary only.
        surfel: Whether the splats are 2DGS discs, which the first two scales
            span. If it is None, the kind is detected: splats with two scales,
            or with tiny and equal third scales, are discs. Otherwise the kind
            follows from the file name that gsplat's trainers choose:
            `ckpt_999.pt` is 2DGS, and `ckpt_999_rank0.pt` is 3DGS.

    Raises:
        FileError: The file is unreadable, is not a checkpoint, or contains an
            invalid value, or 2DGS and 3DGS cannot be distinguished.
        MissingExtraError: torch is not installed.
    """
    tensors = _load_tensors(path)
    n = _check_shapes(path, tensors)
    rest = tensors.get("shN", np.zeros((n, 0, 3)))
    with np.errstate(invalid="ignore"):  # Reported below.
        colors = 0.5 + SH_C0 * tensors["sh0"][:, 0]
    splat = checked_splat(
        path,
        p_GK=tensors["means"],
        quaternions=tensors["quats"],
        scales=exponential(tensors["scales"]),
        opacities=sigmoid(tensors["opacities"].reshape(n)),
        colors=colors,
        sh_rest=rest,
    )
    if splat.is_surfel:
        return splat
    if surfel is None:
        surfel = is_flat(splat) or _name_tells_surfels(path)
    return without_thickness(splat) if surfel else splat


def write_checkpoint(path: Path, splat: GaussianSplat) -> None:
    """Writes a checkpoint that gsplat's trainers and viewers can load.

    All discs are written with the same third scale, by which readers recognise
    discs.

    Raises:
        FileError: The file cannot be written.
        MissingExtraError: torch is not installed.
    """
    torch = _torch()
    thick = with_thickness(splat)
    arrays = {
        "means": thick.p_GK,
        "quats": thick.quaternions,
        "scales": np.log(thick.scales),
        "opacities": logit(thick.opacities),
        "sh0": (thick.colors[:, None] - 0.5) / SH_C0,
        "shN": thick.sh_rest,
    }
    tensors = {
        key: torch.tensor(np.asarray(array), dtype=torch.float32)
        for key, array in arrays.items()
    }
    content = io.BytesIO()
    torch.save({"step": 0, "splats": tensors}, content)
    write_atomically(path, content.getvalue())


def is_checkpoint_archive(names: list[str]) -> bool:
    """Returns whether torch wrote a zip archive with the given entries."""
    return any(name.endswith("/data.pkl") for name in names)


def _load_tensors(path: Path) -> dict[str, np.ndarray]:
    torch = _torch()
    data = read_whole(path)
    _check_archive(path, data)
    try:
        content = torch.load(
            io.BytesIO(data), map_location="cpu", weights_only=True
        )
    except Exception as error:  # torch raises anything on damaged files.
        raise FileError(
            path, "is not a checkpoint that holds only tensors, or is damaged"
        ) from error
    splats: Any = content
    if isinstance(content, dict) and "splats" in content:
        splats = content["splats"]
    if not isinstance(splats, dict):
        raise FileError(
            path, "is not a checkpoint of splats: it holds no dictionary"
        )
    missing = [key for key in _KEYS if key not in splats]
    if missing:
        raise FileError(
            path,
            f"is not a checkpoint of splats: {', '.join(missing)} is missing",
        )
    return {
        key: _array(path, key, splats[key], len(data))
        for key in (*_KEYS, "shN")
        if key in splats
    }


def _check_archive(path: Path, data: bytes) -> None:
    """Checks the sizes in a zip archive; torch's old format is not one."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            sizes = [entry.file_size for entry in archive.infolist()]
    except ZIP_DAMAGES:
        return
    check_unpacked_size(path, len(data), sum(sizes))


def _array(path: Path, key: str, tensor: Any, file_size: int) -> np.ndarray:
    torch = _torch()
    # Sparse tensors, nested tensors and tensors of the meta device contain no
    # rows.
    if (
        not isinstance(tensor, torch.Tensor)
        or not tensor.is_floating_point()
        or tensor.layout != torch.strided
        or tensor.is_nested
        or tensor.device.type != "cpu"
    ):
        raise FileError(
            path, f"{key} is not a tensor of rows of floating-point numbers"
        )
    # A tensor with a stride of zero repeats one number, so its shape may be
    # larger than its data.
    if tensor.numel() * tensor.element_size() > 2 * file_size:
        raise FileError(
            path,
            f"{key} of shape {tuple(tensor.shape)} is larger than the file",
        )
    return tensor.detach().float().numpy()


def _check_shapes(path: Path, tensors: dict[str, np.ndarray]) -> int:
    """Checks that the tensors' shapes match; returns the number of splats."""
    n = len(tensors["means"]) if tensors["means"].ndim else 1
    check_count(path, n)
    rest = tensors.get("shN", np.zeros((n, 0, 3)))
    harmonics = rest.shape[1] if rest.ndim == 3 else 0
    expected = {
        "means": [(n, 3)],
        "quats": [(n, 4)],
        "scales": [(n, 2), (n, 3)],
        "opacities": [(n,), (n, 1)],
        "sh0": [(n, 1, 3)],
        "shN": [(n, harmonics, 3)],
    }
    for key, tensor in tensors.items():
        if tensor.shape not in expected[key]:
            raise FileError(
                path,
                f"{key} has shape {tensor.shape}; expected"
                f" {' or '.join(map(str, expected[key]))}",
            )
    return n


def _name_tells_surfels(path: Path) -> bool:
    if _NAME_OF_3DGS.fullmatch(path.stem):
        return False
    if _NAME_OF_2DGS.fullmatch(path.stem):
        return True
    raise FileError(
        path,
        "cannot determine whether it holds 2DGS or 3DGS: convert it with"
        " `remosplat convert --model 2dgs` or `3dgs`, or keep the trainer's"
        " name, ckpt_N.pt or ckpt_N_rankR.pt",
    )


def _torch():
    try:
        import torch
    except ImportError as error:
        raise MissingExtraError("a checkpoint (.pt)", "gpu") from error
    return torch
