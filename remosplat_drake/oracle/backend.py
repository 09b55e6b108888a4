"""Chooses the backend of an oracle: the CPU, or CUDA kernels on a GPU."""

from importlib.util import find_spec

from remosplat_drake.base.errors import FieldError, unknown_name

BACKENDS = ("auto", "cpu", "cuda")
"""Valid names of backends. "auto" selects "cuda" if it is available, else
"cpu"."""


def choose_backend(asked: str, where: str, field: str) -> str:
    """Chooses the backend that computes distances from spheres to a splat.

    Args:
        asked: One of `BACKENDS`.
        where: The file that contains the value `asked`; errors name this file.
        field: Name of the field that contains the value `asked`.

    Returns:
        Either "cpu" or "cuda".

    Raises:
        FieldError: There is no such backend, or "cuda" cannot work on this
            computer.
    """
    if asked not in BACKENDS:
        raise FieldError(where, field, unknown_name("backend", asked, BACKENDS))
    if asked == "cpu":
        return "cpu"
    problem = missing_for_cuda()
    if asked == "cuda" and problem:
        text = f"the cuda backend {problem}; use cpu or auto"
        raise FieldError(where, field, text)
    return "cpu" if problem else "cuda"


def missing_for_cuda() -> str:
    """Returns what the CUDA kernels lack on this computer; empty if nothing.

    If torch is not installed, this function loads no package.
    """
    problem = _missing_for_torch("torch")
    if problem:
        return problem
    from remosplat_drake.oracle.cuda.program import find_compiler

    return "" if find_compiler() else "needs libnvrtc, CUDA's run-time compiler"


def missing_for_gsplat() -> str:
    """Returns what gsplat lacks on this computer; empty if nothing.

    If torch or gsplat is not installed, this function loads no package.
    """
    problem = _missing_for_torch("torch", "gsplat")
    if problem:
        return problem
    # This import loads gsplat's kernels. A gsplat wheel without compiled
    # kernels compiles them at the first import.
    from gsplat.cuda._backend import _C

    if _C is None:
        return "needs nvcc, since gsplat compiles its kernels at first use"
    return ""


def _missing_for_torch(*packages: str) -> str:
    for package in packages:
        if find_spec(package) is None:
            return f"needs {package}: pip install 'remosplat-drake[gpu]'"
    import torch

    if not torch.cuda.is_available():
        return "needs a CUDA device, and torch finds none"
    return ""
