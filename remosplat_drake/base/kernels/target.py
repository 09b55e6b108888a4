"""Chooses the type of processor for which kernels are compiled.

On x86-64, kernels are compiled for the microarchitecture level v3 (AVX2, FMA),
if this computer's processor supports it. Such kernels run on all processors
with this level. They are only a few percent slower than kernels for the
processor of this computer.
"""

from llvmlite import binding
from numba.core import config, registry

LEVEL = "x86-64-v3"

_FEATURES = ("avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe")


def choose() -> None:
    """Makes Numba compile for x86-64-v3, unless the user set another target.

    The target does not change if Numba has already compiled code.
    """
    if config.CPU_NAME is not None or config.CPU_FEATURES is not None:
        return
    if "_toplevel_target_context" in vars(registry.cpu_target):
        return
    if not binding.get_process_triple().startswith("x86_64"):
        return
    features = binding.get_host_cpu_features()
    if all(features.get(feature) for feature in _FEATURES):
        config.CPU_NAME, config.CPU_FEATURES = LEVEL, ""
