"""Imports packages that need shared libraries of the system.

Drake, Open3D and librealsense link against libraries that pip does not install.
If such a library is missing, a one-line error names it and its Debian package.
For libusb there is a pip package, too, which is used if the system has no
libusb.
"""

import contextlib
import ctypes
import importlib
import platform
import re
from collections.abc import Iterator
from types import ModuleType

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError

DEBIAN_PACKAGES = {
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libX11.so.6": "libx11-6",
    "libglib-2.0.so.0": "libglib2.0-0",
    "libidn2.so.0": "libidn2-0",
    "libudev.so.1": "libudev1",
    "libusb-1.0.so.0": "libusb-1.0-0",
}
"""The Debian and Ubuntu package that contains each shared library."""

_LIBUSB = "libusb-1.0.so.0"

# These patterns match error messages of the dynamic loader, and of Drake, which
# loads the library EGL itself.
_GLIBC = re.compile(r"version `GLIBC_([\d.]+)' not found")
_LIBRARY = re.compile(r"(?:^|/|loading )(lib[^\s/:;]+\.so[\d.]*)[:;]")


class MissingLibraryError(RemoSplatError):
    """Raised if a feature needs a shared library that this system lacks."""


def import_optional(name: str, feature: str, extra: str) -> ModuleType:
    """Imports a package of an extra, which may need libraries of the system.

    Args:
        name: Name of the package to import.
        feature: The feature that needs the package; the error names this
            feature.
        extra: Name of the extra that installs the package.

    Raises:
        MissingExtraError: The package is not installed.
        MissingLibraryError: The package is installed, but this system lacks a
            library that it needs.
    """
    _load_libusb()
    with libraries_named(feature):
        try:
            return importlib.import_module(name)
        except ModuleNotFoundError as error:
            raise MissingExtraError(feature, extra) from error


@contextlib.contextmanager
def libraries_named(feature: str) -> Iterator[None]:
    """Turns import errors about a missing library into one-line errors.

    Args:
        feature: The feature that needs the library; the error names this
            feature.

    Raises:
        MissingLibraryError: A shared library is absent, or glibc is too old.
    """
    try:
        yield
    except (ImportError, RuntimeError) as error:
        missing = _missing(str(error))
        if missing is None:
            raise
        raise MissingLibraryError(f"{feature} needs {missing}") from error


def _missing(problem: str) -> str | None:
    """Returns the library that an error reports as missing, or None."""
    glibc = _GLIBC.search(problem)
    if glibc:
        here = platform.libc_ver()[1]
        return f"glibc {glibc[1]} or newer; this system has {here}"
    library = _LIBRARY.search(problem)
    if not library:
        return None
    package = DEBIAN_PACKAGES.get(library[1])
    hint = f" (on Debian and Ubuntu: apt install {package})" if package else ""
    return f"the system's {library[1]}{hint}"


def _load_libusb() -> None:
    """Loads the system's or pip's libusb, for packages that link against it.

    When the package is imported, the dynamic loader uses the library that is
    already loaded.
    """
    try:
        ctypes.CDLL(_LIBUSB, ctypes.RTLD_GLOBAL)
    except OSError:
        # If neither exists, the import of the package reports the missing
        # library.
        with contextlib.suppress(ImportError, OSError):
            libusb = importlib.import_module("libusb_package")
            path = libusb.get_library_path()
            ctypes.CDLL(str(path), ctypes.RTLD_GLOBAL)
