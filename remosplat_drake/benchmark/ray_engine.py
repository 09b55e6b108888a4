"""Trials on a Ray cluster, whose nodes see the same files."""

import socket

from remosplat_drake.benchmark.engines import (
    DIED,
    MAX_ATTEMPTS,
    ONE_THREAD,
    Results,
    RunTrial,
    guarded,
)
from remosplat_drake.benchmark.trial import Trial, describe
from remosplat_drake.errors import MissingExtraError, RemoSplatError

CONNECT_TIMEOUT = 5.0
"""How long a cluster may take to answer [s]."""


def on_ray(trials: list[Trial], address: str, function: RunTrial) -> Results:
    """Results as they come; a lost worker or node costs nothing.

    Args:
        trials: What to run. Scene files must have the same path everywhere.
        address: Of the cluster, as `ray.init` takes it.
        function: What runs a trial; must be importable by the nodes.

    Raises:
        MissingExtraError: Ray is not installed.
        RemoSplatError: No cluster answers there.
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
        remote = ray.remote(num_cpus=1, max_retries=MAX_ATTEMPTS - 1)(guarded)
        running = {remote.remote(function, trial): trial for trial in trials}
        while running:
            (done, *_), _ = ray.wait(list(running))
            trial = running.pop(done)
            try:
                yield ray.get(done)
            except ray.exceptions.RayError:
                yield describe(trial, error=DIED)
    finally:
        if ours:
            ray.shutdown()


def _check_reachable(address: str) -> None:
    """Ray itself would try for minutes."""
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host:
        return
    try:
        socket.create_connection((host, int(port)), CONNECT_TIMEOUT).close()
    except (OSError, ValueError) as error:
        raise _no_cluster(address) from error


def _no_cluster(address: str) -> RemoSplatError:
    return RemoSplatError(f"--ray: no cluster answers at {address!r}")
