"""Locations of models/, scenarios/ and the user's cache.

In a checkout or an editable install, these folders are beside the package; a
wheel contains them inside the package, in share/. All other modules get these
paths from this module.
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
"""Largest number of files in a folder that is searched for a file of a similar
name."""

PACKAGE_SCHEME = "package://remosplat_drake/"
"""Prefix of the URIs of files that are part of this package."""


def models_dir() -> Path:
    """Returns the directory with the robot and scene models."""
    return _ROOT / "models"


def scenarios_dir() -> Path:
    """Returns the directory with the shipped scenario files."""
    return _ROOT / "scenarios"


def cache_dir() -> Path:
    """Returns the cache directory, in XDG_CACHE_HOME; it need not exist."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "remosplat_drake"


def state_dir() -> Path:
    """Returns the directory for logs, in XDG_STATE_HOME; it need not exist."""
    base = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local/state"
    return Path(base) / "remosplat_drake"


def resolve(uri: str | Path, relative_to: Path | None = None) -> Path:
    """Turns `package://remosplat_drake/...` or a path into an existing path.

    Args:
        uri: A package URI, an absolute path, or a path relative to
            `relative_to` (default: the working directory).
        relative_to: Directory of the file that mentions `uri`.

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
    """Suggests a file with a similar name in the same folder."""
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
