"""`GaussianSplat`: the Gaussians of a scene, as read-only arrays."""

import dataclasses as dc
import hashlib
from collections.abc import Mapping
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.splat.blocks import in_blocks
from remosplat_drake.splat.harmonics import rotated_harmonics
from remosplat_drake.splat.quaternions import (
    quaternion_product,
    rotation_matrices,
)

SH_C0 = 0.28209479177387814
"""Spherical harmonic of degree 0, 1 / (2 sqrt(pi)): colour = 0.5 + SH_C0 f_dc.
"""

LEAST_SCALE, LARGEST_SCALE = 1e-4, 1e4
"""Least and greatest factor by which splats may be scaled [m per unit of the
file]. They correspond to units of a tenth of a millimetre and of ten
kilometres."""


@dc.dataclass(frozen=True, eq=False)
class GaussianSplat:
    """N Gaussians in frame G, activated (linear scales, opacity in (0, 1]).

    Two scales make a 2DGS surfel (Huang et al., 2024): a flat disc whose normal
    is the third column of its rotation. Three scales make a 3DGS ellipsoid
    (Kerbl et al., 2023). The arrays are read-only, so all systems of a diagram
    can share a splat. Copying returns the object itself.

    Attributes:
        p_GK: Centres of the splats K in G, shape (N, 3) [m].
        quaternions: Orientations R_GK as unit quaternions wxyz, shape (N, 4).
        scales: Standard deviations along K's axes, shape (N, 2) or (N, 3) [m].
        opacities: Peak opacities in (0, 1], shape (N,).
        colors: Linear RGB of spherical-harmonics degree 0, shape (N, 3).
        sh_rest: Coefficients of the higher spherical harmonics,
            coefficient-major, shape (N, K, 3) with K = (degree + 1)^2 - 1; K =
            0 if a file has none.
        uncertainty: Bound of the distance by which the true surface may be in
            front of each splat, on the side of a query point, shape (N,), not
            negative [m]; None if it is unknown.

    Raises:
        RemoSplatError: The shapes of the arrays do not match, or a value is
            invalid. The error names the splat.

    Example:
        >>> import remosplat_drake as rs
        >>> uri = "package://remosplat_drake/models/scenes/table/splat.ply"
        >>> splat = rs.read_splat(uri)
        >>> splat.p_GK.shape == (len(splat), 3), splat.is_surfel
        (True, True)
    """

    p_GK: np.ndarray
    quaternions: np.ndarray
    scales: np.ndarray
    opacities: np.ndarray
    colors: np.ndarray
    sh_rest: np.ndarray = dc.field(
        default_factory=lambda: np.zeros((0, 0, 3), np.float32)
    )
    uncertainty: np.ndarray | None = None

    def __post_init__(self):
        n = len(self.p_GK)
        if self.sh_rest.shape[:2] == (0, 0) and n > 0:
            object.__setattr__(self, "sh_rest", np.zeros((n, 0, 3), np.float32))
        for name, values in self.arrays().items():
            array = np.array(values, np.float32, order="C")
            array.flags.writeable = False
            object.__setattr__(self, name, array)
        self._check()

    def arrays(self) -> dict[str, np.ndarray]:
        """Returns the arrays, keyed by attribute; omits those that are None."""
        arrays = {f.name: getattr(self, f.name) for f in dc.fields(self)}
        return {k: array for k, array in arrays.items() if array is not None}

    def _check(self):
        n = len(self.p_GK)
        expected = {
            "p_GK": [(n, 3)],
            "quaternions": [(n, 4)],
            "scales": [(n, 2), (n, 3)],
            "opacities": [(n,)],
            "colors": [(n, 3)],
            "sh_rest": [(n, *self.sh_rest.shape[1:2], 3)],
            "uncertainty": [(n,)],
        }
        for name, values in self.arrays().items():
            if values.shape not in expected[name]:
                raise RemoSplatError(
                    f"{name} has shape {values.shape}; expected"
                    f" {expected[name]}"
                )
        for name, values in self.arrays().items():
            self._reject(~np.isfinite(values), name, "not finite")
        # The sums are written out, since NumPy sums short rows slowly.
        w, x, y, z = np.square(self.quaternions).T
        norms = np.sqrt(w + x + y + z)
        self._reject(np.less(norms, 1e-8), "quaternion", "zero")
        self._reject(self.scales <= 0, "scale", "not positive")
        self._reject(
            (self.opacities <= 0) | (self.opacities > 1),
            "opacity",
            "outside (0, 1]",
        )
        if self.uncertainty is not None:
            self._reject(self.uncertainty < 0, "uncertainty", "negative")
        unit = (self.quaternions / np.maximum(norms, 1e-8)[:, None]).astype(
            np.float32
        )
        unit.flags.writeable = False
        object.__setattr__(self, "quaternions", unit)

    def _reject(self, bad: np.ndarray, what: str, problem: str):
        if bad.any():
            which = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1))
            raise RemoSplatError(
                f"{what} of splat {which[0]} is {problem}"
                f" ({len(which)} such splats)"
            )

    @staticmethod
    def restored(
        arrays: Mapping[str, np.ndarray], content_hash: str | None = None
    ) -> "GaussianSplat":
        """Makes a splat from the arrays of another splat, without checks.

        Args:
            arrays: The arrays, keyed by attribute; they become read-only.
            content_hash: The hash of the other splat. If it is None, the hash
                is computed on demand.
        """
        splat = object.__new__(GaussianSplat)
        for name, array in arrays.items():
            array.flags.writeable = False
            object.__setattr__(splat, name, array)
        if content_hash is not None:
            splat.__dict__["content_hash"] = content_hash
        return splat

    @staticmethod
    def empty() -> "GaussianSplat":
        """Makes a splat that contains no surfels."""
        return GaussianSplat(
            p_GK=np.zeros((0, 3)),
            quaternions=np.zeros((0, 4)),
            scales=np.zeros((0, 2)),
            opacities=np.zeros(0),
            colors=np.zeros((0, 3)),
        )

    def __len__(self) -> int:
        return len(self.p_GK)

    def __deepcopy__(self, memo) -> "GaussianSplat":
        return self

    @property
    def is_surfel(self) -> bool:
        """Whether the splats are flat 2DGS discs and not 3DGS ellipsoids."""
        return self.scales.shape[1] == 2

    @cached_property
    def R_GK(self) -> np.ndarray:
        """Rotation matrices of the splats, shape (N, 3, 3), read-only."""
        wxyz = self.quaternions.astype(np.float64)
        # Quaternions are normalised in double precision, since their rounding
        # to single precision causes errors of 1e-7.
        wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
        R = rotation_matrices(wxyz)
        R.flags.writeable = False
        return R

    @cached_property
    def content_hash(self) -> str:
        """First 16 digits of the SHA-256 digest of all arrays, in hex."""
        digest = hashlib.sha256()
        for array in self.arrays().values():
            digest.update(array.data if array.size else b"")
        return digest.hexdigest()[:16]

    def select(self, keep: np.ndarray | slice) -> "GaussianSplat":
        """Returns the splats that a mask, an index array or slice selects."""
        chosen = {name: array[keep] for name, array in self.arrays().items()}
        return self._with(chosen)

    def _with(self, arrays: dict[str, np.ndarray]) -> "GaussianSplat":
        """Returns this splat with other arrays, which are not checked."""
        ordered = {k: np.ascontiguousarray(v) for k, v in arrays.items()}
        return GaussianSplat.restored(ordered)

    def joined_with(self, other: "GaussianSplat") -> "GaussianSplat":
        """Appends other splats of the same kind and degree.

        Args:
            other: The splats to append.

        Raises:
            RemoSplatError: Only one of the two has a known uncertainty. Zeros
                for the other one would be wrong.
        """
        first, second = self.arrays(), other.arrays()
        if ("uncertainty" in first) != ("uncertainty" in second):
            raise RemoSplatError(
                "splats of known and of unknown uncertainty cannot be joined; "
                "give the latter a value with with_uncertainty"
            )
        return GaussianSplat(
            **{k: np.concatenate([first[k], second[k]]) for k in first}
        )

    def with_uncertainty(
        self, uncertainty: np.ndarray | float | None
    ) -> "GaussianSplat":
        """Returns these splats with another `uncertainty`.

        Args:
            uncertainty: The uncertainty of each splat, shape (N,), or one
                number for all splats [m]; None if it is unknown.
        """
        if uncertainty is not None:
            uncertainty = np.broadcast_to(uncertainty, len(self))
        return dc.replace(self, uncertainty=uncertainty)

    def inside(self, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
        """Returns whether each splat's centre is in a box in G.

        Args:
            lower: Lower corner of the box, shape (3,) [m].
            upper: Upper corner of the box, shape (3,) [m].

        Returns:
            A mask of the splats, shape (N,), bool.
        """
        inside = (self.p_GK >= lower) & (self.p_GK <= upper)
        return np.all(inside, axis=1)

    def cropped(self, lower: np.ndarray, upper: np.ndarray) -> "GaussianSplat":
        """Returns the splats with centres in a box [lower, upper] of G [m]."""
        return self.select(self.inside(lower, upper))

    def without_harmonics(self) -> "GaussianSplat":
        """Returns these splats with colours of degree 0 only.

        These colours do not depend on the viewing direction. They are
        sufficient for distances and for the drawings of this library.
        """
        return self._with(self.arrays() | {"sh_rest": self.sh_rest[:, :0]})

    def transformed(
        self, X_FG: RigidTransform, scale: float = 1.0
    ) -> "GaussianSplat":
        """Expresses the splats in another frame F, and in other units.

        A centre becomes p_FK = X_FG (scale p_GK). Scales and uncertainty are
        multiplied by `scale`, and view-dependent colours are rotated.

        Args:
            X_FG: Pose of the splats' frame G in F.
            scale: Length in F of one unit of G, positive.

        Raises:
            RemoSplatError: A splat would become too small or too large for
                single precision.
        """
        if X_FG.IsExactlyIdentity() and scale == 1.0:
            return self

        def part(rows: slice) -> dict[str, np.ndarray]:
            return self.select(rows)._transformed(X_FG, scale).arrays()

        return GaussianSplat.restored(in_blocks(len(self), part))

    def _transformed(
        self, X_FG: RigidTransform, scale: float
    ) -> "GaussianSplat":
        R_FG = X_FG.rotation()
        p_FK = scale * self.p_GK.astype(np.float64) @ R_FG.matrix().T
        sh_rest, uncertainty = self.sh_rest, self.uncertainty
        if sh_rest.shape[1] and not R_FG.IsExactlyIdentity():
            sh_rest = rotated_harmonics(sh_rest, R_FG.matrix())
        if uncertainty is not None:
            uncertainty = scale * uncertainty.astype(np.float64)
        with np.errstate(over="ignore"):  # Overflow raises an error.
            return GaussianSplat(
                p_GK=p_FK + X_FG.translation(),
                quaternions=quaternion_product(
                    R_FG.ToQuaternion().wxyz(),
                    self.quaternions.astype(np.float64),
                ),
                scales=scale * self.scales.astype(np.float64),
                opacities=self.opacities,
                colors=self.colors,
                sh_rest=sh_rest,
                uncertainty=uncertainty,
            )
