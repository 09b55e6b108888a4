"""`Discs`: the parameters of a 2DGS splat that training optimises."""

import math

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor, nn

from remosplat_drake.splat.gaussian_splat import GaussianSplat


class Discs(nn.Module):
    """Trainable, unconstrained parameters of n discs K.

    The properties convert the parameters to physical values.

    Args:
        splat: The splat in W that determines the initial discs.
        scale_limits: Bounds of a disc's standard deviations, as factors of its
            initial ones.

    Attributes:
        p_WK: Centres, (n, 3) [m].
        quaternions: Orientations as quaternions wxyz of any length, (n, 4).
        log_scales: Logarithms of the standard deviations, (n, 2).
        logits: Logits of the opacities, (n,).
        colors: RGB in [0, 1], (n, 3).
    """

    def __init__(self, splat: GaussianSplat, scale_limits: tuple[float, float]):
        super().__init__()
        opacities = splat.opacities.clip(1e-3, 1 - 1e-3)
        self.p_WK = _parameter(splat.p_GK)
        self.quaternions = _parameter(splat.quaternions)
        self.log_scales = _parameter(np.log(splat.scales))
        self.logits = _parameter(np.log(opacities / (1 - opacities)))
        self.colors = _parameter(splat.colors)
        for name, limit in zip(("_least", "_most"), scale_limits, strict=True):
            bound = self.log_scales.detach() + math.log(limit)
            self.register_buffer(name, bound, persistent=False)

    def __len__(self) -> int:
        return len(self.p_WK)

    @property
    def opacity(self) -> Tensor:
        """Opacities of the discs, shape (n,), in (0, 1)."""
        return torch.sigmoid(self.logits)

    @property
    def scales(self) -> Tensor:
        """Standard deviations of the discs, shape (n, 2) [m]."""
        return torch.exp(self.log_scales)

    @property
    def R_WK(self) -> Tensor:
        """Orientations R_WK of the discs, (n, 3, 3), with normals as z axes."""
        w, x, y, z = F.normalize(self.quaternions, dim=-1).unbind(-1)
        rows = (
            (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
        )
        return torch.stack([torch.stack(row, dim=-1) for row in rows], dim=-2)

    @property
    def normal_W(self) -> Tensor:
        """Unit normals of the discs in W, shape (n, 3)."""
        return self.R_WK[..., 2]

    @torch.no_grad()
    def clamp(self):
        """Clamps scales and colours to their limits."""
        self.log_scales.clamp_(self._least, self._most)
        self.colors.clamp_(0, 1)

    @torch.no_grad()
    def splat(self, min_opacity: float = 0.0) -> GaussianSplat:
        """Converts the discs to a `GaussianSplat` of NumPy arrays.

        Args:
            min_opacity: Discs below this opacity are left out.
        """
        splat = GaussianSplat(
            p_GK=_array(self.p_WK),
            quaternions=_array(self.quaternions),
            scales=_array(self.scales),
            opacities=_array(self.opacity),
            colors=_array(self.colors),
        )
        return splat.select(splat.opacities >= min_opacity)


def _parameter(array: np.ndarray) -> nn.Parameter:
    return nn.Parameter(torch.tensor(array, dtype=torch.float32))


def _array(tensor: Tensor) -> np.ndarray:
    return tensor.detach().cpu().numpy()
