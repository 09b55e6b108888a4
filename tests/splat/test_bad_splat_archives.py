"""Zip archives that hold no good splat: SOG bundles and checkpoints."""

import io
import json
import sys
import warnings
import zipfile

import pytest
import torch
from PIL import Image
from toy_splats import rejected

from remosplat_drake.splat.formats import read_splat

PNG = b"\x89PNG\r\n\x1a\n" + bytes(20)


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


def changed_meta(data: bytes, field: str, value) -> bytes:
    def change(name, content):
        if name != "meta.json":
            return content
        meta = json.loads(content)
        *parents, last = field.split(".")
        target = meta
        for parent in parents:
            target = target[parent]
        if value is None:
            del target[last]
        else:
            target[last] = value
        return json.dumps(meta)

    return resaved(data, change)


@pytest.mark.parametrize(
    ("field", "value", "problem"),
    [
        ("version", 1, "SOG version 1; only version 2"),
        ("version", None, "SOG version None"),
        ("count", "many", "count is no whole number"),
        ("count", 0, "holds no splats"),
        ("count", 10**12, "announces 1000000000000 splats"),
        ("count", 30, "25 pixels|pixels for 30 splats"),
        ("means", 3, "means.files is missing"),
        ("means.mins", [0, 0], "means.mins is no list of 3"),
        ("means.maxs", [0, 0, 1e999], "means.maxs is no list of 3 finite"),
        ("means.maxs", [0, 0, 1e9], "p_GK of splat .* is not finite"),
        ("means.files", ["means_l.webp"], "no list of 2 names"),
        ("quats.files", ["../../secret"], "no list of 1 names"),
        ("quats.files", ["nowhere.webp"], "nowhere.webp is missing"),
        ("quats.files", ["meta.json"], "meta.json is no WebP picture"),
        ("quats.files", ["means_l.webp"], None),
        ("quats.files", ["sh0.webp"], "splat .* has no rotation"),
        ("scales.codebook", [1, 2], "scales.codebook is no list of 256"),
        ("sh0.codebook", ["x"] * 256, "sh0.codebook is no list of 256"),
        ("shN", {"count": 1, "bands": 9}, "expected 1 to 3 bands"),
    ],
)
def test_sog_descriptions(tmp_path, whole_files, field, value, problem):
    path = tmp_path / "s.sog"
    path.write_bytes(changed_meta(whole_files[".sog"], field, value))
    if problem is None:  # Alpha is 255 there, as for the last component.
        assert len(read_splat(path)) == 20
    else:
        rejected(path, problem)


def test_sog_parts(tmp_path, whole_files):
    path = tmp_path / "s.sog"
    huge = io.BytesIO()
    Image.new("RGBA", (4000, 4000)).save(huge, "WEBP", lossless=True)
    for name, content, problem in [
        ("meta.json", "[1]", "expected a JSON object"),
        ("meta.json", "{", "no JSON"),
        ("meta.json", "[" * 10**6, "no JSON"),
        ("meta.json", " " * 2**25, "has 33554432 bytes"),
        ("quats.webp", bytes(2**27), "announce 134217728 unpacked bytes"),
        ("quats.webp", PNG, "quats.webp is no WebP picture"),
        ("quats.webp", huge.getvalue(), "4000 x 4000 pixels for 20"),
    ]:
        path.write_bytes(
            resaved(
                whole_files[".sog"],
                lambda part, old, n=name, c=content: c if part == n else old,
            )
        )
        rejected(path, problem)


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


@pytest.mark.filterwarnings("ignore:Sparse CSR tensor support")
@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"sh0": None}, "sh0 is missing"),
        ({"quats": torch.ones(4, 3)}, r"quats has shape \(4, 3\); expected"),
        ({"scales": torch.ones(3, 3)}, r"\(4, 2\) or \(4, 3\)"),
        ({"shN": torch.ones(4, 3)}, "shN has shape"),
        ({"opacities": torch.zeros(4).int()}, "opacities is no tensor"),
        ({"opacities": [0.0] * 4}, "opacities is no tensor"),
        ({"means": torch.zeros(0, 3)}, "holds no splats"),
        ({"means": torch.full((4, 3), torch.nan)}, "p_GK of splat 0"),
        ({"quats": torch.zeros(4, 4)}, "quaternion is zero"),
        ({"means": torch.zeros(1).expand(10**9, 3)}, "larger than the file"),
        ({"means": torch.tensor(1.0)}, r"means has shape \(\); expected"),
        ({"shN": torch.tensor(1.0)}, r"shN has shape \(\); expected"),
        ({"means": torch.zeros(4, 3).to_sparse()}, "means is no tensor"),
        ({"quats": torch.ones(4, 4).to_sparse_csr()}, "quats is no tensor"),
        ({"scales": torch.zeros(4, 3, device="meta")}, "scales is no tensor"),
        ({"sh0": nested_tensor()}, "sh0 is no tensor"),
    ],
)
def test_checkpoint_tensors(tmp_path, changes, problem):
    save(tmp_path / "ckpt_0.pt", **changes)
    rejected(tmp_path / "ckpt_0.pt", problem)


def test_checkpoints_run_no_code(tmp_path):
    path = tmp_path / "ckpt_0.pt"
    torch.save({"splats": Exploding()}, path)
    rejected(path, "no checkpoint of tensors alone")
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
    rejected(path, "made to fill the memory")
