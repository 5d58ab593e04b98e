"""The workers: a cluster on this machine, or a running one."""

import importlib.util
import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager

import dask
from distributed import CancelledError, Client, LocalCluster
from distributed.comm import CommClosedError
from tornado.ioloop import PeriodicCallback

from damper_estimator.errors import InputError

_TIMEOUT = 10  # s within which a scheduler must answer
_LOOPBACK = "127.0.0.1"
_SETTINGS = {
    # Dask stores an hour of profiling samples: a megabyte for each second of short tasks.
    "distributed.worker.profile.enabled": False,
    # After this time a missing worker counts as lost and is replaced at the next check.
    "distributed.deploy.lost-worker-timeout": "5s",
}
_CHECK_PERIOD = 1000  # ms between two checks of the workers started here


@contextmanager
def connected(scheduler: str | None, workers: int | None, memory: str) -> Iterator[Client]:
    """A client of the scheduler at an address, or of local workers that are started here and stop with the block.

    Local workers are processes with one thread each, also in the linear algebra library, and listen only on the
    loopback address.

    Args:
        scheduler: such as ``tcp://10.0.0.1:8786``; None for this machine.
        workers: how many are started here; None for one per core.
        memory: limit of each worker started here, such as ``2GiB``; ``auto`` shares the available memory. A worker
            above the limit is restarted, as is one that dies for another reason.

    Raises:
        InputError: if no scheduler answers, or the limit is not an amount of memory.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if scheduler is None:
        with dask.config.set(_SETTINGS), _local(workers or os.cpu_count() or 1, memory) as cluster:
            with Client(cluster) as client:
                yield client
        return
    try:
        client = Client(scheduler, timeout=_TIMEOUT)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"{scheduler}: no scheduler answers; start one (dask scheduler) or omit --scheduler"
        ) from error
    with client:
        yield client


@contextmanager
def answering() -> Iterator[None]:
    """Reports a scheduler that is lost within the block.

    Raises:
        InputError: if the scheduler is lost.
    """
    try:
        yield
    except (CancelledError, CommClosedError, TimeoutError) as error:
        raise InputError("the scheduler is lost; finished results are kept: start again to continue") from error


def _local(workers: int, memory: str) -> LocalCluster:
    try:
        cluster = LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host=_LOOPBACK,
            dashboard_address=f"{_LOOPBACK}:0",
            worker_dashboard_address=None,
            memory_limit=memory,
            silence_logs=False,
        )
    except ValueError as error:
        raise InputError(f"--memory {memory}: is not an amount of memory; give for example 2GiB, or auto") from error
    # Dask restarts workers by itself, except one that dies while starting.
    worker_check = PeriodicCallback(lambda: cluster.scale(workers), _CHECK_PERIOD)
    cluster.periodic_callbacks["worker-check"] = worker_check  # the cluster stops them when it ends
    cluster.loop.add_callback(worker_check.start)
    return cluster


def dashboard_of(client: Client) -> str:
    """Address of Dask's dashboard; "" without bokeh, which draws it."""
    return client.dashboard_link if importlib.util.find_spec("bokeh") else ""


def threads_of(client: Client) -> int:
    """Number of tasks that run at the same time; 0 without a worker."""
    return sum(client.nthreads().values())
