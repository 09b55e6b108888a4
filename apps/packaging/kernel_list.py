"""Lists the kernels that runs need, for first starts: `make kernels`.

A start on another machine compiles the listed kernels on all cores, before
their arguments exist.
"""

from apps.packaging.used_kernels import used
from remosplat_drake.app.compiling import RUN_KERNELS
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.kernels.listing import listed

if __name__ == "__main__":
    write_atomically(RUN_KERNELS, listed(used("{}")))
