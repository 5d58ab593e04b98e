"""The workers: a cluster on this machine, or one that is there."""

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

_PATIENCE = 10  # s in which a scheduler must answer
_LOOPBACK = "127.0.0.1"
_SETTINGS = {
    # Dask keeps an hour of samples of what its workers do: a megabyte for each second of short tasks.
    "distributed.worker.profile.enabled": False,
    # After this a worker that has not come back counts as lost, and is replaced at the next roll call.
    "distributed.deploy.lost-worker-timeout": "5s",
}
_ROLL_CALL = 1000  # ms between two counts of the workers started here


@contextmanager
def connected(scheduler: str | None, workers: int | None, memory: str) -> Iterator[Client]:
    """A client of the scheduler at an address, or of workers that are started here and end with the block.

    Workers of this machine are processes with one thread each, also in the linear algebra library, and listen on the
    loopback address alone.

    Args:
        scheduler: such as ``tcp://10.0.0.1:8786``; None for this machine.
        workers: how many are started here; None for one per core.
        memory: limit of each worker started here, such as ``2GiB``; ``auto`` shares what there is. A worker over it is
            started anew, as is one that dies for another reason.

    Raises:
        InputError: where no scheduler answers, or the limit is no amount of memory.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if scheduler is None:
        with dask.config.set(_SETTINGS), _local(workers or os.cpu_count() or 1, memory) as cluster:
            with Client(cluster) as client:
                yield client
        return
    try:
        client = Client(scheduler, timeout=_PATIENCE)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"{scheduler}: no scheduler answers there; start one (dask scheduler) or leave --scheduler out"
        ) from error
    with client:
        yield client


@contextmanager
def answering() -> Iterator[None]:
    """What is asked of a scheduler within the block.

    Raises:
        InputError: where the scheduler is gone.
    """
    try:
        yield
    except (CancelledError, CommClosedError, TimeoutError) as error:
        raise InputError("the scheduler is gone; what was done is kept: start again to go on") from error


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
        raise InputError(f"--memory {memory}: is no amount of memory; write such as 2GiB, or auto") from error
    # Dask starts a worker anew by itself, except one that dies while it starts.
    roll_call = PeriodicCallback(lambda: cluster.scale(workers), _ROLL_CALL)
    cluster.periodic_callbacks["roll-call"] = roll_call  # the cluster stops them when it ends
    cluster.loop.add_callback(roll_call.start)
    return cluster


def dashboard_of(client: Client) -> str:
    """Address of the page on which Dask shows its work; "" where it offers none: bokeh, which draws it, is missing."""
    return client.dashboard_link if importlib.util.find_spec("bokeh") else ""


def threads_of(client: Client) -> int:
    """How many tasks the cluster does at a time; 0 while no worker is there."""
    return sum(client.nthreads().values())
