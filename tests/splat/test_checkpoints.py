"""gsplat's checkpoints: their tensors, and which model they are of."""

import math

import numpy as np
import pytest
from test_packed_records import SPLAT, expect
from toy_splats import random_splat

from remosplat_drake.base.errors import FileError
from remosplat_drake.splat.codecs.checkpoint import (
    read_checkpoint,
    write_checkpoint,
)
from remosplat_drake.splat.formats import read_splat
from remosplat_drake.splat.gaussian_splat import SH_C0

torch = pytest.importorskip("torch", reason="needs torch, of the extra `gpu`")


@pytest.mark.parametrize("old", [True, False])
def test_checkpoint(tmp_path, old):
    tensors = {
        "means": torch.tensor([[1.0, -2.0, 3.0]]),
        "quats": torch.tensor([[2.0, 0.0, -2.0, 0.0]]),
        "scales": torch.tensor([[0.0, -1.0, -5.0]]),
        "opacities": torch.tensor([math.log(1.5)], requires_grad=True),
        "sh0": torch.tensor([[[-0.5 / SH_C0, -0.3 / SH_C0, 0.5 / SH_C0]]]),
        "shN": torch.arange(9.0).reshape(1, 3, 3),
    }
    path = tmp_path / "ckpt_7_rank0.pt"
    content = {"step": 7, "splats": tensors}
    torch.save(content, path, _use_new_zipfile_serialization=not old)
    splat = read_splat(path)
    expect(splat)
    np.testing.assert_allclose(splat.colors, SPLAT.colors, atol=1e-6)
    np.testing.assert_array_equal(splat.sh_rest[0, 1], [3, 4, 5])
    # The dictionary of tensors alone, and half precision, do as well.
    halves = {key: tensor.detach().half() for key, tensor in tensors.items()}
    torch.save(halves, path)
    assert read_checkpoint(path, surfel=True).scales.shape == (1, 2)


def test_a_checkpoint_s_name_tells_its_model(tmp_path):
    """The third scale of gsplat's 2DGS is left as it was initialised."""
    ellipsoids = random_splat(3)
    discs = tmp_path / "ckpt_999.pt"
    write_checkpoint(discs, ellipsoids)
    np.testing.assert_allclose(
        read_splat(discs).scales, ellipsoids.scales[:, :2], rtol=1e-6
    )
    assert not read_splat(discs, surfel=False).is_surfel
    other = discs.rename(tmp_path / "ckpt_6999_rank0.pt")
    np.testing.assert_allclose(
        read_splat(other).scales, ellipsoids.scales, rtol=1e-6
    )
    unnamed = other.rename(tmp_path / "table.pt")
    with pytest.raises(FileError, match="convert --model 2dgs"):
        read_splat(unnamed)
    assert read_checkpoint(unnamed, surfel=True).is_surfel


def test_a_checkpoint_s_scales_may_tell_its_model(tmp_path):
    discs = random_splat(2)
    path = tmp_path / "table.pt"
    write_checkpoint(path, discs)
    np.testing.assert_allclose(read_splat(path).scales, discs.scales, rtol=1e-6)
    content = torch.load(path, weights_only=True)
    content["splats"]["scales"] = content["splats"]["scales"][:, :2]
    torch.save(content, path)
    assert read_splat(path).is_surfel
