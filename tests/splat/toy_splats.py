"""Small seeded splats, and errors of bad files, for the tests of files."""

import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import GaussianSplat


def random_splat(
    scales: int = 3, harmonics: int = 0, n: int = 20, seed: int = 7
) -> GaussianSplat:
    """Splats within a few metres, of 1 mm to 1 m."""
    rng = np.random.default_rng(seed)
    return GaussianSplat(
        p_GK=rng.normal(size=(n, 3)),
        quaternions=rng.normal(size=(n, 4)),
        scales=np.exp(rng.uniform(np.log(1e-3), 0, (n, scales))),
        opacities=rng.uniform(0.01, 1, n),
        colors=rng.uniform(0, 1, (n, 3)),
        sh_rest=rng.uniform(-0.9, 0.9, (n, harmonics, 3)),
    )


def rejected(path: Path, problem: str | None = None) -> str:
    """The error of a file, which must name it in one line."""
    with pytest.raises(FileError, match=problem) as caught:
        read_splat(path)
    message = str(caught.value)
    assert str(path) in message
    assert "\n" not in message
    assert len(caught.value.problem) < 200
    return message


def resaved(data: bytes, change) -> bytes:
    """A zip with one of its files changed: `change(name, content)`."""
    content = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(data)) as before,
        zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as after,
    ):
        for name in before.namelist():
            after.writestr(name, change(name, before.read(name)))
    return content.getvalue()
