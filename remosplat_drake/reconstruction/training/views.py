"""A capture's images as tensors on the training device."""

import dataclasses as dc

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.surfels.normals import depth_normals


@dc.dataclass(frozen=True, eq=False)
class Views:
    """Posed RGB-D images of one size, as tensors on the training device.

    There are v images.

    Attributes:
        X_CW: Poses of W in the cameras C (OpenCV axes), (v, 4, 4).
        K: Intrinsic matrices, (v, 3, 3) [pixels].
        rgb: Colours in [0, 1], (v, h, w, 3).
        depth: Depth z in C, (v, h, w) [m]; 0 where unknown.
        front: Least known depth of a pixel and its neighbours, (v, h, w) [m];
            inf where none of them is known.
        normal_C: Surface normals towards C, (v, h, w, 3); 0 where unknown.
        shown: Mask of the pixels that show the scene, (v, h, w), bool.
    """

    X_CW: Tensor
    K: Tensor
    rgb: Tensor
    depth: Tensor
    front: Tensor
    normal_C: Tensor
    shown: Tensor

    def __len__(self) -> int:
        return len(self.X_CW)

    def __getitem__(self, indices: Tensor) -> "Views":
        """Returns the views with the given indices."""
        return Views(*(getattr(self, f.name)[indices] for f in dc.fields(self)))

    @property
    def rays_C(self) -> Tensor:
        """Directions (x, y, 1) of the pixels in C, shape (v, h, w, 3)."""
        height, width = self.depth.shape[1:]
        u = torch.arange(width, device=self.K.device) + 0.5
        v = torch.arange(height, device=self.K.device) + 0.5
        K = self.K[:, :, :, None, None]
        x = ((u - K[:, 0, 2]) / K[:, 0, 0]).expand(-1, height, -1)
        y = ((v[:, None] - K[:, 1, 2]) / K[:, 1, 1]).expand(-1, -1, width)
        return torch.stack([x, y, torch.ones_like(x)], dim=-1)

    @staticmethod
    def of_capture(capture: Capture, device: str) -> "Views":
        """Copies all views of a capture to a torch device."""

        def tensor(array: np.ndarray) -> Tensor:
            return torch.tensor(array, dtype=torch.float32, device=device)

        normals = [
            depth_normals(K, depth)
            for K, depth in zip(capture.K, capture.depth, strict=True)
        ]
        hidden = capture.hidden
        if hidden is None:
            hidden = np.zeros(capture.depth.shape, bool)
        depth = tensor(capture.depth)
        return Views(
            X_CW=tensor(np.linalg.inv(capture.X_WC)),
            K=tensor(capture.K),
            rgb=tensor(capture.rgb) / 255.0,
            depth=depth,
            front=_front(depth),
            normal_C=tensor(np.nan_to_num(np.array(normals))),
            shown=torch.tensor(~hidden, device=device),
        )


def _front(depth: Tensor) -> Tensor:
    """Least known depth around each pixel, for discs at silhouettes."""
    far = torch.where(depth > 0, depth, torch.inf)
    return -F.max_pool2d(-far, 3, stride=1, padding=1)
