"""Gaussian splats: the scene as arrays, its files and its hierarchy."""

from remosplat_drake.splat.gaussian_splat import GaussianSplat

__all__ = ["GaussianSplat"]
