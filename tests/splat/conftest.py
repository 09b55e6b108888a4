"""Fixtures for the tests of splat files."""

import pytest
from optional import HAS_TORCH
from toy_splats import random_splat

from remosplat_drake.splat.codecs.spz import write_spz
from remosplat_drake.splat.formats import CHECKPOINT, FORMATS, write_splat


@pytest.fixture(scope="session")
def whole_files(tmp_path_factory) -> dict[str, bytes]:
    """A good file of each format, and of both containers of SPZ.

    Without torch there are no checkpoints.
    """
    folder = tmp_path_factory.mktemp("whole")
    splat = random_splat(3, 3)
    files = {}
    for format_ in FORMATS:
        if format_ is CHECKPOINT and not HAS_TORCH:
            continue
        path = folder / f"ckpt_0{format_.suffix}"
        write_splat(path, splat)
        files[format_.suffix] = path.read_bytes()
    write_spz(folder / "v4.spz", splat, version=4)
    files["4.spz"] = (folder / "v4.spz").read_bytes()
    return files
