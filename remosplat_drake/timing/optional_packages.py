"""Lists other packages that are measured for comparison if installed."""

from collections.abc import Iterable

from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.base.system_libraries import import_optional

REQUIREMENTS = {
    "daqp": "daqp",
    "open3d": "'remosplat-drake[reconstruction]'",
    "proxsuite": "proxsuite",
    "rtree": "rtree",
    "trimesh": "trimesh",
}
"""Requirements for pip, keyed by the name of the imported package."""


def is_there(package: str) -> bool:
    """Returns whether a package can be imported.

    Args:
        package: One of `REQUIREMENTS`.
    """
    return _problem(package) is None


def advice(packages: Iterable[str]) -> str:
    """Returns advice on installing the packages that cannot be imported.

    Args:
        packages: Some of `REQUIREMENTS`.

    Returns:
        A line with the packages to install, and one for each missing library of
        the system; empty if nothing is missing.
    """
    absent, lines = [], []
    for package in packages:
        problem = _problem(package)
        if isinstance(problem, MissingExtraError):
            absent.append(REQUIREMENTS[package])
        elif problem is not None:
            lines.append(str(problem))
    if absent:
        command = f"pip install {' '.join(absent)}"
        lines.insert(0, f"To compare with other packages: {command}")
    return "\n".join(lines)


def _problem(package: str) -> RemoSplatError | None:
    try:
        import_optional(package, f"timing {package}", REQUIREMENTS[package])
    except RemoSplatError as error:
        return error
    return None
