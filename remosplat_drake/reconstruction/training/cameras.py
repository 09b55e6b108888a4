"""`Cameras`: small errors of the cameras, as unknowns of the training.

A view's true pose is R_WC = exp(theta_W) R_given, p_WC = p_given + t_W, as in
`alignment.perturbation`. All views share the same lens, a matrix L with which a
ray r = (x, y, 1) has the pixel K L r. They also share the same depth curve, z =
offset + (1 + scale) z_given + growth z_given².
"""

import dataclasses as dc

import numpy as np
import torch
from torch import Tensor, nn

from remosplat_drake.capture.capture import Capture
from remosplat_drake.reconstruction.alignment.camera_correction import corrected
from remosplat_drake.reconstruction.alignment.camera_errors import (
    ASPECT,
    CENTER_X,
    CENTER_Y,
    COUNT,
    FOCAL,
    GROWTH,
    OFFSET,
    SCALE,
    CameraPrior,
)
from remosplat_drake.reconstruction.alignment.perturbation import perturbed
from remosplat_drake.reconstruction.training.views import Views


@dc.dataclass(frozen=True)
class CameraDeviations:
    """Prior standard deviations of cameras' errors.

    A deviation of zero means that the parameter is exact.

    Attributes:
        turn: Rotation of a view, about each axis [rad].
        shift: Position of a view, along each axis [m].
        camera: Deviations of parameters that all views share: focal lengths,
            principal point, and scale, offset and growth of the depth. All
            other camera errors are assumed zero.
    """

    turn: float = 0.01
    shift: float = 0.01
    camera: CameraPrior = dc.field(default_factory=CameraPrior)


class Cameras(nn.Module):
    """The errors of the cameras of v views; they are initially zero.

    Parameters are in units of their standard deviations. So the same learning
    rate is suitable for millimetres, pixels and angles, and the negative log
    prior is a sum of squares.

    Args:
        X_WC: Given poses, shape (v, 4, 4).
        deviations: Standard deviations of the errors.
        trained: Mask of the views that are used in training, shape (v,), bool.
            `hold_frame` fixes their mean pose.

    Attributes:
        poses: theta_W and t_W of each view, (v, 6).
        lens: Logarithms of the factors of f_x and f_y, then the shift of the
            principal point as a fraction of f_x and f_y, (4,).
        depth: Scale, offset and growth of the depth, (3,).
    """

    def __init__(
        self,
        X_WC: np.ndarray,
        deviations: CameraDeviations,
        trained: np.ndarray,
    ):
        super().__init__()
        d, common = deviations, deviations.camera
        self.poses = nn.Parameter(torch.zeros(len(X_WC), 6))
        self.lens = nn.Parameter(torch.zeros(4))
        self.depth = nn.Parameter(torch.zeros(3))
        p_WC = X_WC[:, :3, 3]
        for name, values in (
            ("_pose_units", [d.turn] * 3 + [d.shift] * 3),
            ("_lens_units", [common.focal] * 2 + [common.center] * 2),
            ("_depth_units", [common.scale, common.offset, common.growth]),
            ("_arms", p_WC - p_WC[trained].mean(axis=0)),
        ):
            values = torch.tensor(values, dtype=torch.float32)
            self.register_buffer(name, values, persistent=False)
        self.register_buffer("_trained", torch.tensor(trained), False)

    @property
    def motion(self) -> Tensor:
        """theta_W [rad] and t_W [m] of each view, shape (v, 6)."""
        return self.poses * self._pose_units

    @property
    def L(self) -> Tensor:
        """The lens matrix, applied to rays before K, (3, 3)."""
        fx, fy, x, y = (self.lens * self._lens_units).unbind()
        zero, one = torch.zeros_like(fx), torch.ones_like(fx)
        rows = (fx.exp(), zero, x), (zero, fy.exp(), y), (zero, zero, one)
        return torch.stack([torch.stack(row) for row in rows])

    @property
    def errors(self) -> np.ndarray:
        """Errors that all images share, see `camera_errors`, (`COUNT`,)."""
        fx, fy, x, y = (self.lens * self._lens_units).tolist()
        errors = np.zeros(COUNT)
        errors[[SCALE, OFFSET, GROWTH]] = self._depth_errors().tolist()
        errors[FOCAL] = np.expm1(fx)
        errors[ASPECT] = np.exp(fy) - np.exp(fx)
        errors[[CENTER_X, CENTER_Y]] = x, y
        return errors

    def corrected(self, views: Views, index: Tensor) -> Views:
        """Returns views with corrected cameras, differentiable in all errors.

        Args:
            views: k views with the given cameras.
            index: Indices of these views among the v views, shape (k,).
        """
        theta_W, t_W = self.motion[index].split(3, dim=-1)
        R_CW, p_CW = views.X_CW[:, :3, :3], views.X_CW[:, :3, 3:]
        p_WC = t_W[..., None] - R_CW.mT @ p_CW
        R_CW = R_CW @ torch.linalg.matrix_exp(_cross(-theta_W))
        X_CW = torch.cat([R_CW, -R_CW @ p_WC], dim=-1)
        return dc.replace(
            views,
            X_CW=torch.cat([X_CW, views.X_CW[:, 3:]], dim=1),
            K=views.K @ self.L,
            depth=self._true_depth(views.depth),
            front=self._true_depth(views.front),
        )

    def prior(self, index: Tensor) -> Tensor:
        """Computes the errors' negative log prior, as a mean over some views.

        The prior of the shared lens and depth errors has the weight of one of
        the v views.

        Args:
            index: Indices of the views, shape (k,).
        """
        common = (self.lens**2).sum() + (self.depth**2).sum()
        each = (self.poses[index] ** 2).sum(dim=-1).mean()
        return 0.5 * (each + common / len(self.poses))

    @torch.no_grad()
    def hold_frame(self):
        """Removes the trained views' common rotation, translation and scale.

        Images do not determine a motion that all cameras and discs have in
        common. The scale of the given positions is kept, too, since otherwise
        training would shrink the world: a smaller world has smaller losses.
        """
        self.poses -= self.poses[self._trained].mean(dim=0)
        arms, t_W = self._arms[self._trained], self.poses[self._trained, 3:]
        scale = (arms * t_W).sum() / (arms**2).sum().clamp(min=1e-12)
        self.poses[:, 3:] -= scale * self._arms

    @torch.no_grad()
    def capture(self, given: Capture) -> Capture:
        """Returns the capture of all v views with corrected cameras."""
        motion = self.motion.cpu().double().numpy()
        moved = dc.replace(given, X_WC=perturbed(given.X_WC, motion))
        return corrected(moved, self.errors)

    def _depth_errors(self) -> Tensor:
        return self.depth * self._depth_units

    def _true_depth(self, z: Tensor) -> Tensor:
        """Corrects known depths; 0 and inf do not change."""
        scale, offset, growth = self._depth_errors()
        known = (z > 0) & z.isfinite()
        z_known = torch.where(known, z, 0)
        true = offset + (1 + scale) * z_known + growth * z_known**2
        return torch.where(known, true.clamp(min=0), z)


def _cross(v: Tensor) -> Tensor:
    """The matrices [v×] of vectors (k, 3), shape (k, 3, 3)."""
    axes = torch.eye(3, dtype=v.dtype, device=v.device)
    return torch.linalg.cross(v[:, None], axes[None]).mT
