"""Compiles CUDA C++ at run time, and launches kernels on torch's stream.

The compiler NVRTC is part of every CUDA build of torch, and every system with
an NVIDIA GPU has the driver. So users need neither nvcc nor a C++ compiler nor
another package. Compiled code is kept in the user's cache.
"""

import contextlib
import ctypes
import hashlib
import importlib.util
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from remosplat_drake.base import resources
from remosplat_drake.base.atomic_file import write_atomically
from remosplat_drake.base.errors import RemoSplatError

SOURCES = Path(__file__).parent / "sources"
"""Folder of the kernels' sources."""

_HANDLE = ctypes.c_void_p


class Program:
    """The kernels of one source file, loaded on one device.

    Args:
        source: Name of the file in `SOURCES`.
        device: Index of the CUDA device.

    Raises:
        RemoSplatError: The compiler or the driver is missing or fails.
    """

    def __init__(self, source: str, device: int):
        import torch

        self._driver = _driver()
        major, minor = torch.cuda.get_device_capability(device)
        code = _compiled(source, 10 * major + minor, str(torch.version.cuda))
        handle = ctypes.c_int()
        self._call("cuDeviceGet", ctypes.byref(handle), device)
        self._context, self._module = _HANDLE(), _HANDLE()
        # This is the same CUDA context as torch's.
        context = ctypes.byref(self._context)
        self._call("cuDevicePrimaryCtxRetain", context, handle)
        self._call("cuCtxSetCurrent", self._context)
        self._call("cuModuleLoadData", ctypes.byref(self._module), code)
        self._device = torch.device("cuda", device)
        self._kernels: dict[str, ctypes.c_void_p] = {}

    def launch(
        self,
        kernel: str,
        blocks: int,
        threads: int,
        arguments: Sequence[Any],
        shared_bytes: int = 0,
    ) -> None:
        """Launches a kernel on torch's current stream, asynchronously.

        Args:
            kernel: Name of the kernel.
            blocks: Number of blocks.
            threads: Number of threads of a block.
            arguments: ctypes values or structures, in the order of the kernel's
                parameters.
            shared_bytes: Size of a block's dynamic shared memory.
        """
        import torch

        if kernel not in self._kernels:
            found = _HANDLE()
            self._call(
                "cuModuleGetFunction",
                ctypes.byref(found),
                self._module,
                kernel.encode(),
            )
            self._kernels[kernel] = found
        addresses = (_HANDLE * len(arguments))(
            *[ctypes.addressof(argument) for argument in arguments]
        )
        stream = torch.cuda.current_stream(self._device).cuda_stream
        # A CPU thread that has not used this device yet has no CUDA context.
        self._call("cuCtxSetCurrent", self._context)
        self._call(
            "cuLaunchKernel",
            self._kernels[kernel],
            *(blocks, 1, 1, threads, 1, 1, shared_bytes),
            _HANDLE(stream),
            addresses,
            None,
        )

    def _call(self, name: str, *arguments):
        status = getattr(self._driver, name)(*arguments)
        if status:
            text = ctypes.c_char_p()
            self._driver.cuGetErrorName(status, ctypes.byref(text))
            reason = (text.value or b"").decode() or f"error {status}"
            raise RemoSplatError(f"CUDA: {name} fails with {reason}")


@cache
def load_program(source: str, device: int) -> Program:
    """Returns the `Program` of a source file, which is loaded only once."""
    return Program(source, device)


def find_compiler() -> ctypes.CDLL | None:
    """Returns the NVRTC that torch contains; None if there is none."""
    import torch

    major = str(torch.version.cuda).split(".")[0]
    name = f"libnvrtc.so.{major}"
    # NVRTC finds its second library by its name if this library is already
    # loaded.
    for path in _brought(f"libnvrtc-builtins.so.{major}"):
        with contextlib.suppress(OSError):
            ctypes.CDLL(str(path))
    for path in [*_brought(name), name]:
        with contextlib.suppress(OSError):
            return ctypes.CDLL(str(path))
    return None


def _brought(name: str) -> list[Path]:
    """Returns the path of a library from NVIDIA's wheels; None if absent."""
    spec = importlib.util.find_spec("nvidia")
    folders = spec.submodule_search_locations if spec else None
    return [
        path
        for folder in folders or ()
        for path in sorted(Path(folder).glob(f"*/lib/{name}*"))
    ]


@cache
def _driver() -> ctypes.CDLL:
    try:
        return ctypes.CDLL("libcuda.so.1")
    except OSError as error:
        raise RemoSplatError(
            f"CUDA's driver is missing: {error}; use the cpu backend"
        ) from error


def _compiled(source: str, capability: int, version: str) -> bytes:
    """Returns the machine code of a source, from the cache if possible."""
    main = (SOURCES / source).read_bytes()
    headers = {p.name: p.read_bytes() for p in sorted(SOURCES.glob("*.cuh"))}
    digest = hashlib.sha256(f"{capability} {version}".encode())
    for text in (main, *headers.values()):
        digest.update(text)
    name = f"{Path(source).stem}-{digest.hexdigest()[:16]}.bin"
    path = resources.cache_dir() / "cuda" / name
    try:
        return path.read_bytes()
    except OSError:
        pass  # The file is not in the cache yet.
    code = compile_source(source, main, headers, capability)
    write_atomically(path, code)
    return code


def compile_source(
    name: str, source: bytes, headers: dict[str, bytes], capability: int
) -> bytes:
    """Compiles a source with NVRTC.

    Args:
        name: Name of the source, for messages.
        source: Text of the source.
        headers: Texts of the included files, keyed by name.
        capability: Compute capability of the device; 90 means 9.0.

    Raises:
        RemoSplatError: NVRTC is missing, or cannot compile the source.
    """
    nvrtc = find_compiler()
    if nvrtc is None:
        raise RemoSplatError(
            "CUDA's run-time compiler, libnvrtc, is missing; install torch with"
            " CUDA, or use the cpu backend"
        )
    n = len(headers)
    program = _HANDLE()
    nvrtc.nvrtcCreateProgram(
        ctypes.byref(program),
        source,
        name.encode(),
        n,
        (ctypes.c_char_p * n)(*headers.values()),
        (ctypes.c_char_p * n)(*[header.encode() for header in headers]),
    )
    count = ctypes.c_int()
    nvrtc.nvrtcGetNumSupportedArchs(ctypes.byref(count))
    known = (ctypes.c_int * count.value)()
    nvrtc.nvrtcGetSupportedArchs(known)
    # If the compiler does not support the GPU, it generates PTX code, which the
    # driver translates.
    kind = "CUBIN" if capability in known else "PTX"
    arch = f"sm_{capability}" if kind == "CUBIN" else f"compute_{max(known)}"
    options = [
        f"--gpu-architecture={arch}".encode(),
        b"-std=c++17",
        # This option allows generic lambdas in device code.
        b"--device-as-default-execution-space",
    ]
    failed = nvrtc.nvrtcCompileProgram(
        program, len(options), (ctypes.c_char_p * len(options))(*options)
    )
    if failed:
        log = _result(nvrtc, program, "ProgramLog").rstrip(b"\0")
        raise RemoSplatError(f"CUDA: {log.decode(errors='replace')}")
    code = _result(nvrtc, program, kind)
    nvrtc.nvrtcDestroyProgram(ctypes.byref(program))
    return code


def _result(nvrtc: ctypes.CDLL, program: ctypes.c_void_p, what: str) -> bytes:
    size = ctypes.c_size_t()
    getattr(nvrtc, f"nvrtcGet{what}Size")(program, ctypes.byref(size))
    buffer = ctypes.create_string_buffer(size.value)
    getattr(nvrtc, f"nvrtcGet{what}")(program, buffer)
    return buffer.raw
