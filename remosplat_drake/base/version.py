"""The version of this package, told in one place."""

__version__ = "0.2.0"
