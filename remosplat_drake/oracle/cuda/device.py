"""Copies data of splats and queries to a CUDA device."""

from typing import TYPE_CHECKING

import numpy as np

from remosplat_drake.base.errors import RemoSplatError
from remosplat_drake.oracle.backend import missing_for_cuda
from remosplat_drake.oracle.cuda.clusters import (
    Clusters,
    ClustersArgument,
    split_positions,
)
from remosplat_drake.robot.sphere_batch import SphereBatch

if TYPE_CHECKING:
    import torch
    from torch import Tensor


class DeviceClusters:
    """Copies of `Clusters` on a CUDA device.

    Attributes:
        device: The CUDA device, which was torch's current device at
            construction.
        multiprocessors: Number of the device's multiprocessors.
        records: Copy of `Clusters.records`. The other arrays of `Clusters` are
            copied to attributes of the same names.
        argument: The kernels' argument, which contains the addresses of the
            copies.
    """

    def __init__(self, clusters: Clusters):
        self.device = current_device()
        import torch

        self.multiprocessors = torch.cuda.get_device_properties(
            self.device
        ).multi_processor_count
        self.records = to_device(clusters.records, self.device)
        self.clusters = to_device(clusters.clusters, self.device)
        self.groups = to_device(clusters.groups, self.device)
        self.order = to_device(clusters.order, self.device)
        self.argument = ClustersArgument.of(self, lambda t: t.data_ptr())


def current_device() -> "torch.device":
    """Returns torch's current CUDA device.

    Raises:
        RemoSplatError: torch or a CUDA device is missing.
    """
    problem = missing_for_cuda()
    if problem:
        raise RemoSplatError(f"the cuda backend {problem}")
    import torch

    return torch.device("cuda", torch.cuda.current_device())


def to_device(array: np.ndarray, device: "torch.device") -> "Tensor":
    """Copies an array to a device."""
    import torch

    return torch.from_numpy(np.ascontiguousarray(array)).to(device)


def sphere_rows(
    p_WS: np.ndarray, reach: np.ndarray, ignore_below: np.ndarray
) -> np.ndarray:
    """Makes the rows by which kernels read spheres.

    Args:
        p_WS: Centres, shape (n, 3) [m].
        reach: Distances from the centres below which kernels search for
            surfaces, shape (n,) [m].
        ignore_below: Heights below which splats are ignored, shape (n,) [m].

    Returns:
        Split positions, reaches and heights, shape (n, 8), float32. Heights are
        rounded up. They exclude the same splats as before, since the heights of
        splats are single-precision numbers, too.
    """
    rows = np.empty((len(p_WS), 8), np.float32)
    rows[:, :6] = split_positions(p_WS)
    rows[:, 6] = np.minimum(reach, np.float32(1e30))
    floor = np.clip(ignore_below, -1e30, 1e30)
    rows[:, 7] = floor
    up = np.nextafter(rows[:, 7], np.float32(np.inf))
    rows[:, 7] = np.where(rows[:, 7] < floor, up, rows[:, 7])
    return rows


def batch_rows(
    batch: SphereBatch, reach: np.ndarray, device: "torch.device"
) -> "Tensor":
    """Makes the `sphere_rows` of a batch as a tensor, shape (c n, 8), float32.

    Args:
        batch: The spheres.
        reach: As in `sphere_rows`; the same for all configurations, shape (n,)
            [m].
        device: The device.

    Raises:
        ValueError: A centre is not finite.
    """
    import torch

    p_WS = torch.as_tensor(batch.p_WS).detach().to(device, torch.float64)
    if not bool(torch.isfinite(p_WS.sum())):
        raise ValueError("a sphere's centre is not finite")
    ends = sphere_rows(
        np.zeros((len(reach), 3)), reach, on_host(batch.ignore_below)
    )
    c, n, _ = p_WS.shape
    rows = torch.empty((c, n, 8), dtype=torch.float32, device=device)
    rows[..., :3] = p_WS
    rows[..., 3:6] = p_WS - rows[..., :3]
    rows[..., 6:] = to_device(ends[:, 6:], device)
    return rows.view(c * n, 8)


def on_host(array) -> np.ndarray:
    """Returns an array or a tensor as a NumPy array in double precision."""
    if isinstance(array, np.ndarray):
        return array.astype(float)
    return array.detach().cpu().numpy().astype(float)


def like(answer: "Tensor", asked) -> "np.ndarray | Tensor":
    """Converts a tensor to the query's type: NumPy array or torch tensor."""
    if isinstance(asked, np.ndarray):
        return answer.cpu().numpy().astype(float)
    return answer.to(asked.device, asked.dtype)
