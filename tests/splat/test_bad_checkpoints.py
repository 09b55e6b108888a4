"""Checkpoints that hold no good splat."""

import sys
import warnings

import pytest
from toy_splats import rejected, resaved

torch = pytest.importorskip("torch", reason="needs torch, of the extra `gpu`")


def save(path, **changes):
    tensors = {
        "means": torch.zeros(4, 3),
        "quats": torch.ones(4, 4),
        "scales": torch.zeros(4, 3),
        "opacities": torch.zeros(4),
        "sh0": torch.zeros(4, 1, 3),
        **changes,
    }
    kept = {key: t for key, t in tensors.items() if t is not None}
    torch.save({"splats": kept}, path)


def nested_tensor():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # They are a prototype.
        return torch.nested.nested_tensor([torch.zeros(1, 3)] * 4)


def signalling_nan():
    """Arithmetic warns of it, unlike of the usual NaN."""
    bits = torch.full((4, 1, 3), 0x7FA00000, dtype=torch.int32)
    return bits.view(torch.float32)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.filterwarnings("ignore:Sparse CSR tensor support")
@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"sh0": None}, "sh0 is missing"),
        ({"quats": torch.ones(4, 3)}, r"quats has shape \(4, 3\); expected"),
        ({"scales": torch.ones(3, 3)}, r"\(4, 2\) or \(4, 3\)"),
        ({"shN": torch.ones(4, 3)}, "shN has shape"),
        ({"opacities": torch.zeros(4).int()}, "opacities is not a tensor"),
        ({"opacities": [0.0] * 4}, "opacities is not a tensor"),
        ({"means": torch.zeros(0, 3)}, "holds no splats"),
        ({"means": torch.full((4, 3), torch.nan)}, "p_GK of splat 0"),
        ({"sh0": signalling_nan()}, "colors of splat 0"),
        ({"quats": torch.zeros(4, 4)}, "quaternion is zero"),
        ({"means": torch.zeros(1).expand(10**9, 3)}, "larger than the file"),
        ({"means": torch.tensor(1.0)}, r"means has shape \(\); expected"),
        ({"shN": torch.tensor(1.0)}, r"shN has shape \(\); expected"),
        ({"means": torch.zeros(4, 3).to_sparse()}, "means is not a tensor"),
        ({"quats": torch.ones(4, 4).to_sparse_csr()}, "quats is not a tensor"),
        (
            {"scales": torch.zeros(4, 3, device="meta")},
            "scales is not a tensor",
        ),
        ({"sh0": nested_tensor()}, "sh0 is not a tensor"),
    ],
)
def test_checkpoint_tensors(tmp_path, changes, problem):
    save(tmp_path / "ckpt_0.pt", **changes)
    rejected(tmp_path / "ckpt_0.pt", problem)


def test_checkpoints_run_no_code(tmp_path):
    path = tmp_path / "ckpt_0.pt"
    torch.save({"splats": Exploding()}, path)
    rejected(path, "not a checkpoint that holds only tensors")
    torch.save([1, 2], path)
    rejected(path, "no dictionary")


class Exploding:
    def __reduce__(self):
        return sys.exit, (3,)


def test_a_checkpoint_that_swells(tmp_path, whole_files):
    path = tmp_path / "ckpt_0.pt"
    path.write_bytes(
        resaved(
            whole_files[".pt"],
            lambda name, old: bytes(2**27) if name.endswith("/0") else old,
        )
    )
    rejected(path, "made to exhaust the memory")
