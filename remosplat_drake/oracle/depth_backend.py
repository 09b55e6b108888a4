"""Choice of the backend for depth views: the CPU, or gsplat on a GPU."""

from importlib.util import find_spec

from remosplat_drake.base.errors import FieldError, unknown_name

BACKENDS = ("auto", "cpu", "cuda")
"""Valid backends; "auto" is "cuda" wherever that can work."""


def choose_backend(asked: str, is_surfel: bool, where: str, field: str) -> str:
    """Chooses the backend that renders depth views.

    Args:
        asked: One of `BACKENDS`; "auto" is "cuda" wherever that can work.
        is_surfel: Whether the splat has 2DGS discs; the GPU renders no
            ellipsoids.
        where: The file that errors name.
        field: The field of that file that asked.

    Returns:
        Either "cpu" or "cuda".

    Raises:
        FieldError: There is no such backend, or "cuda" cannot work here.
    """
    if asked not in BACKENDS:
        raise FieldError(where, field, unknown_name("backend", asked, BACKENDS))
    if asked == "cpu":
        return "cpu"
    problem = missing_for_cuda() if is_surfel else "renders 2DGS discs only"
    if asked == "cuda" and problem:
        raise FieldError(where, field, f"cuda {problem}; valid here: cpu, auto")
    return "cpu" if problem else "cuda"


def missing_for_cuda() -> str:
    """Says what keeps the GPU from rendering; empty if nothing does.

    Where torch or gsplat is not installed, this loads neither.
    """
    for package in ("torch", "gsplat"):
        if find_spec(package) is None:
            return f"needs {package}: pip install 'remosplat-drake[gpu]'"
    import torch

    if not torch.cuda.is_available():
        return "needs a CUDA device, and torch finds none"
    # Loads gsplat's kernels; its pure wheel compiles them once.
    from gsplat.cuda._backend import _C

    if _C is None:
        return "needs nvcc, with which gsplat compiles its kernels once"
    return ""
