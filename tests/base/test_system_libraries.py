"""System libraries that pip does not install are loaded, or named in one line.

The dynamic loader itself complains here: about libusb's own file, in which
the name of something that it wants is changed.
"""

import subprocess
import sys
from pathlib import Path

import pytest

from remosplat_drake.base.errors import MissingExtraError
from remosplat_drake.base.system_libraries import (
    MissingLibraryError,
    import_optional,
    libraries_named,
)

libusb_package = pytest.importorskip(
    "libusb_package", reason="needs the extra `reconstruction`"
)


def importing(monkeypatch, folder: Path, old: bytes, new: bytes) -> str:
    """Imports a package of which the loader will not have it; the error."""
    library = Path(libusb_package.get_library_path()).read_bytes()
    assert old in library and len(old) == len(new)
    (folder / "native.so").write_bytes(library.replace(old, new))
    monkeypatch.syspath_prepend(folder)
    with pytest.raises(MissingLibraryError) as caught:
        import_optional("native", "seeing", "reconstruction")
    return str(caught.value)


def test_an_absent_library_is_named(tmp_path, monkeypatch):
    line = importing(monkeypatch, tmp_path, b"libc.so.6", b"libq.so.6")
    assert line == "seeing needs the system's libq.so.6"


def test_an_old_glibc_is_named(tmp_path, monkeypatch):
    line = importing(monkeypatch, tmp_path, b"GLIBC_2.17", b"GLIBC_9.99")
    assert line.startswith("seeing needs glibc 9.99 or newer; this system has")


def test_a_known_library_comes_with_the_name_of_its_package():
    with (
        pytest.raises(
            MissingLibraryError,
            match=r"seeing needs the system's libX11\.so\.6"
            r" \(on Debian and Ubuntu: apt install libx11-6\)",
        ),
        libraries_named("seeing"),
    ):
        raise ImportError(
            "libX11.so.6: cannot open shared object file: No such file or"
            " directory"
        )


def test_what_drake_loads_by_itself_is_named_too():
    with (
        pytest.raises(MissingLibraryError, match="apt install libegl1"),
        libraries_named("rendering"),
    ):
        raise RuntimeError(
            "Drake could not initialize EGL by loading libEGL.so.1; please see"
            " https://drake.mit.edu/troubleshooting.html#gl-init for help."
        )


def test_other_errors_stay_what_they_are():
    with pytest.raises(RuntimeError, match="no power"), libraries_named("x"):
        raise RuntimeError("no power")


def test_a_package_that_is_not_installed_is_of_an_extra():
    with pytest.raises(MissingExtraError, match=r"\[panda\]"):
        import_optional("no_such_package", "seeing", "panda")


def test_libusb_is_there_for_those_that_link_against_it():
    """In a process of its own: what is loaded stays loaded."""
    program = (
        "import ctypes\n"
        "from remosplat_drake.base import system_libraries\n"
        "system_libraries._load_libusb()\n"
        "ctypes.CDLL('libusb-1.0.so.0')"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
