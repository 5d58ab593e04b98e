"""Queries to the workers that have recordings in memory, repeated elsewhere when workers are lost."""

from collections.abc import Callable, Iterable, Sequence
from time import sleep

import numpy as np
from distributed import Client, Future, KilledWorker, wait

from damper_estimator.errors import InputError
from damper_estimator.fleet.cluster import answering
from damper_estimator.fleet.worker_recordings import Source, Summary, answers, channel_below, channel_range, summary
from damper_estimator.identification.samples import Samples
from damper_estimator.model import DamperModel
from damper_estimator.model.model_files import model_yaml
from damper_estimator.numerics import order_statistics

CHECK_PERIOD = 5.0  # s between two checks for lost workers
PAUSE = 0.2  # s between two checks while there is no worker
_RETRIES = 4  # of a query whose worker was lost
_DYING = (
    "workers die repeatedly while they process their recordings; they may need more memory (--memory), "
    "or reveal a fault: try fleet compare on these recordings"
)


class DistributedRecordings:
    """Recordings, each with the worker that is preferred for queries about it; final.

    Attributes:
        sources: usable recordings, in order.
        summaries: one per source.
        refused: reasons by source for the unusable ones.
    """

    def __init__(self, client: Client, sources: Iterable[Source], model: DamperModel) -> None:
        self._client, self._model = client, model_yaml(model)
        self._workers = sorted(client.nthreads()) or [None]
        self.sources = tuple(sorted(sources, key=lambda source: (source.recording, source.damper)))
        results = self._query(summary)
        self.refused = {
            source: str(error)
            for source, error in zip(self.sources, results, strict=True)
            if isinstance(error, InputError)
        }
        self.sources = tuple(source for source in self.sources if source not in self.refused)
        self.summaries: list[Summary] = [result for result in results if not isinstance(result, InputError)]
        if not self.sources:
            raise InputError(
                f"no recording can be used; the first: {next(iter(self.refused.values()), 'none was given')}"
            )

    def ask(self, query: Callable, *arguments: object) -> list:
        """The results of a query of ``worker_recordings``, in the order of the sources.

        Raises:
            InputError: if a recording has become unusable, or workers or scheduler are lost.
        """
        results = self._query(query, *arguments)
        for result in results:
            if isinstance(result, InputError):
                raise result
        return results

    def _query(self, query: Callable, *arguments: object) -> list:
        count = len(self._workers)
        futures = [self._submitted(k, query, arguments) for k in range(count)]
        retries, results = [0] * count, [None] * len(self.sources)
        try:
            with answering():
                while (gathered := self._gathered(futures)) is None:
                    for k, worker in self._replacements(futures):
                        retries[k] += 1
                        if retries[k] > _RETRIES:
                            raise InputError(_DYING)
                        self._workers[k] = worker
                        futures[k].cancel()
                        futures[k] = self._submitted(k, query, arguments)
        except BaseException:
            for future in futures:
                future.release()  # a query that kills workers must not be retried while the error is handled
            raise
        for k, answer in enumerate(gathered):
            results[k::count] = answer
        return results

    def _replacements(self, futures: Sequence[Future]) -> list[tuple[int, str]]:
        """Index of each open query whose worker is lost, and a live worker to replace it.

        Dask never reassigns a task whose preferred worker died while there was no other, and blames the death of a
        worker on every task waiting there: a task that it has given up is not necessarily the cause.
        """
        live = sorted(self._client.nthreads())
        if not live:
            sleep(PAUSE)
            return []
        lost = [
            k for k, future in enumerate(futures)
            if _is_given_up(future) or (self._workers[k] not in live and future.status not in ("finished", "error"))
        ]  # fmt: skip
        return [(k, live[k % len(live)]) for k in lost]

    def _submitted(self, k: int, query: Callable, arguments: Sequence) -> Future:
        """A query about the recordings of the k-th worker, sent to it if it is alive."""
        return self._client.submit(
            answers, self.sources[k :: len(self._workers)], self._model, query, arguments,
            workers=self._workers[k], allow_other_workers=True, pure=False,
        )  # fmt: skip

    def _gathered(self, futures: Sequence[Future]) -> list | None:
        """The results; None while some are missing."""
        client = self._client
        try:
            wait(futures, CHECK_PERIOD)
            return client.sync(lambda: client.gather(futures, asynchronous=True), callback_timeout=CHECK_PERIOD)
        except (KilledWorker, TimeoutError):
            return None

    def channel(self, row: int) -> Samples:
        """The judged samples of a row of the block, as ``identification.samples.Channels``; only counts are sent."""
        counts, lows, highs = zip(*self.ask(channel_range, row), strict=True)
        size, low, high = int(sum(counts)), min(lows), max(highs)
        if not size:
            low = high = np.nan

        def below(edges: Sequence[float]) -> np.ndarray:
            return np.sum(self.ask(channel_below, row, np.asarray(edges, float)), axis=0)

        return Samples(size, low, high, below, lambda ranks: order_statistics(below, low, high, ranks))


def _is_given_up(query: Future) -> bool:
    return query.status == "error" and isinstance(query.exception(), KilledWorker)
