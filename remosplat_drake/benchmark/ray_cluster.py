"""Runs jobs on a Ray cluster with a shared file system."""

import socket
from collections.abc import Iterable

from remosplat_drake.base.child_process import ONE_THREAD
from remosplat_drake.base.errors import MissingExtraError, RemoSplatError
from remosplat_drake.base.pool import MAX_ATTEMPTS, Job, Results

CONNECT_TIMEOUT = 5.0
"""A cluster must answer within this time [s]."""


def on_ray(jobs: Iterable[Job], address: str) -> Results:
    """Runs jobs on a cluster; repeats jobs whose worker or node was lost.

    Args:
        jobs: Jobs to run. Scene files must have the same path on all nodes, and
            all nodes must be able to import the jobs' functions.
        address: Address of the cluster, as `ray.init` takes it.

    Raises:
        MissingExtraError: Ray is not installed.
        RemoSplatError: No cluster answers at the address.
    """
    try:
        import ray
    except ImportError as error:
        raise MissingExtraError("--ray", "cluster") from error

    ours = not ray.is_initialized()
    if ours:
        _check_reachable(address)
        try:
            ray.init(
                address=address,
                runtime_env={"env_vars": ONE_THREAD},
                log_to_driver=False,
                logging_level="ERROR",
            )
        except (ConnectionError, ValueError) as error:
            raise _no_cluster(address) from error
    try:
        run = ray.remote(num_cpus=1, max_retries=MAX_ATTEMPTS - 1)(Job.run)
        queue, running = iter(jobs), dict[object, Job]()
        while True:
            # The number of nodes may change. Some jobs are always queued, so
            # that no node is idle.
            cores = ray.cluster_resources().get("CPU", 1)
            while len(running) < 2 * cores:
                if (job := next(queue, None)) is None:
                    break
                running[run.remote(job)] = job
            if not running:
                return
            (done, *_), _ = ray.wait(list(running))
            job = running.pop(done)
            try:
                result = ray.get(done)
            except ray.exceptions.RayError:
                result = job.died()
            yield result
    finally:
        if ours:
            ray.shutdown()


def _check_reachable(address: str) -> None:
    """Raises an error if no cluster listens.

    Ray itself would try to connect for minutes.
    """
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host:
        return
    try:
        socket.create_connection((host, int(port)), CONNECT_TIMEOUT).close()
    except (OSError, ValueError) as error:
        raise _no_cluster(address) from error


def _no_cluster(address: str) -> RemoSplatError:
    return RemoSplatError(
        "--ray: no cluster answers; start one, or correct the address "
        f"{address!r}"
    )
