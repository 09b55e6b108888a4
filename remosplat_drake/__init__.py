"""Reactive mobile manipulation on Gaussian splats, as a Drake diagram."""

__version__ = "0.1.0"
