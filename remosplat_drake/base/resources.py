"""Finds the folders models/ and scenarios/, and the user's cache and logs.

In a checkout or an editable install, models/ and scenarios/ are beside the
package. A wheel contains them inside the package, in share/. All other modules
get these paths from this module.
"""

import itertools
import os
from difflib import get_close_matches
from pathlib import Path

from remosplat_drake.base.errors import FileError

_PACKAGE = Path(__file__).resolve().parents[1]
_WHEEL_SHARE = _PACKAGE / "share"
_ROOT = _WHEEL_SHARE if _WHEEL_SHARE.is_dir() else _PACKAGE.parent

_MOST = 10_000
"""An error suggests a file with a similar name only if the folder contains at
most this many files."""

PACKAGE_SCHEME = "package://remosplat_drake/"
"""Prefix of the URIs of files that are part of this package."""


def models_dir() -> Path:
    """Returns the directory with the robot and scene models."""
    return _ROOT / "models"


def scenarios_dir() -> Path:
    """Returns the directory with the shipped scenario files."""
    return _ROOT / "scenarios"


def cache_dir() -> Path:
    """Returns the cache folder in XDG_CACHE_HOME, which need not exist."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "remosplat_drake"


def state_dir() -> Path:
    """Returns the folder for logs in XDG_STATE_HOME, which need not exist."""
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local/state"
    return Path(base) / "remosplat_drake"


def resolve(uri: str | Path, relative_to: Path | None = None) -> Path:
    """Returns the path of an existing file, given as package URI or path.

    Args:
        uri: A URI `package://remosplat_drake/...`, an absolute path, or a path
            relative to `relative_to`.
        relative_to: Folder of the file that contains `uri`; by default, the
            working directory.

    Raises:
        FileError: There is no such file.
    """
    path = expand(uri)
    if relative_to is not None and not path.is_absolute():
        path = relative_to / path
    if not path.exists():
        raise FileError(str(uri), f"no such file{_guess(path)}")
    return path


def _guess(path: Path) -> str:
    """Returns a hint at a file with a similar name in the same folder."""
    try:
        names = [x.name for x in itertools.islice(path.parent.iterdir(), _MOST)]
    except OSError:
        return ""
    close = get_close_matches(path.name, names, n=1, cutoff=0.8)
    return f" (did you mean {close[0]!r}?)" if close else ""


def expand(uri: str | Path) -> Path:
    """Expands a `package://remosplat_drake/...` URI or `~` to a path.

    Args:
        uri: A package URI or a path, which need not exist.
    """
    text = str(uri)
    if text.startswith(PACKAGE_SCHEME):
        return _ROOT / text.removeprefix(PACKAGE_SCHEME)
    return Path(text).expanduser()
