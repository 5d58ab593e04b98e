"""Questions to the workers that hold recordings, and what becomes of them when workers are lost."""

from collections.abc import Callable, Iterable, Sequence
from time import sleep

import numpy as np
from distributed import Client, Future, KilledWorker, wait

from damper_estimator.errors import InputError
from damper_estimator.fleet.cluster import answering
from damper_estimator.fleet.held import Source, Summary, answers, channel_below, channel_range, summary
from damper_estimator.identification.samples import Samples
from damper_estimator.model import DamperModel
from damper_estimator.model.model_files import model_yaml
from damper_estimator.numerics import order_statistics

LOOK = 5.0  # s between two looks for workers that are gone
PAUSE = 0.2  # s between two looks for any worker
_AGAIN = 4  # times that a question is asked anew because its worker was lost
_DYING = (
    "workers die again and again over the recordings that they hold; they may need more memory (--memory), "
    "or show a fault: try fleet compare on them"
)


class Shares:
    """The recordings, each with a worker that is asked about it first; final.

    Attributes:
        sources: that can be used, in order.
        summaries: of each.
        refused: reasons by source, of those that cannot.
    """

    def __init__(self, client: Client, sources: Iterable[Source], model: DamperModel) -> None:
        self._client, self._model = client, model_yaml(model)
        self._workers = sorted(client.nthreads()) or [None]
        self.sources = tuple(sorted(sources, key=lambda own: (own.recording, own.damper)))
        told = self._asked(summary)
        self.refused = {s: str(own) for s, own in zip(self.sources, told, strict=True) if isinstance(own, InputError)}
        self.sources = tuple(own for own in self.sources if own not in self.refused)
        self.summaries: list[Summary] = [own for own in told if not isinstance(own, InputError)]
        if not self.sources:
            raise InputError(
                f"no recording can be used; the first: {next(iter(self.refused.values()), 'there is none')}"
            )

    def ask(self, question: Callable, *words: object) -> list:
        """The answers of ``held`` to a question, in the order of the sources.

        Raises:
            InputError: where a recording could be used before and cannot now, or workers or scheduler are lost.
        """
        told = self._asked(question, *words)
        for own in told:
            if isinstance(own, InputError):
                raise own
        return told

    def _asked(self, question: Callable, *words: object) -> list:
        count = len(self._workers)
        futures = [self._submitted(k, question, words) for k in range(count)]
        asked_anew, told = [0] * count, [None] * len(self.sources)
        try:
            with answering():
                while (gathered := self._gathered(futures)) is None:
                    for k, worker in self._heirs(futures):
                        asked_anew[k] += 1
                        if asked_anew[k] > _AGAIN:
                            raise InputError(_DYING)
                        self._workers[k] = worker
                        futures[k].cancel()
                        futures[k] = self._submitted(k, question, words)
        except BaseException:
            for own in futures:
                own.release()  # a question that ends workers must not be tried on while the error is looked at
            raise
        for k, own in enumerate(gathered):
            told[k::count] = own
        return told

    def _heirs(self, futures: Sequence[Future]) -> list[tuple[int, str]]:
        """Index of each question that is open and whose worker is gone, and a worker that lives in its stead.

        Dask never gives away a task whose preferred worker died while no other was there, and blames a worker's death
        on all that waits there: what it has given up is no more to blame than the others.
        """
        live = sorted(self._client.nthreads())
        if not live:
            sleep(PAUSE)
            return []
        lost = [
            k for k, own in enumerate(futures)
            if _is_given_up(own) or (self._workers[k] not in live and own.status not in ("finished", "error"))
        ]  # fmt: skip
        return [(k, live[k % len(live)]) for k in lost]

    def _submitted(self, k: int, question: Callable, words: Sequence) -> Future:
        """A question about the recordings of the k-th worker, to it if it lives."""
        return self._client.submit(
            answers, self.sources[k :: len(self._workers)], self._model, question, words,
            workers=self._workers[k], allow_other_workers=True, pure=False,
        )  # fmt: skip

    def _gathered(self, futures: Sequence[Future]) -> list | None:
        """The answers; None where some are not there yet."""
        client = self._client
        try:
            wait(futures, LOOK)
            return client.sync(lambda: client.gather(futures, asynchronous=True), callback_timeout=LOOK)
        except (KilledWorker, TimeoutError):
            return None

    def channel(self, row: int) -> Samples:
        """The judged samples of a row of the block, for ``identification.samples.Channels``; only counts travel."""
        counts, lows, highs = zip(*self.ask(channel_range, row), strict=True)
        size, low, high = int(sum(counts)), min(lows), max(highs)
        if not size:
            low = high = np.nan

        def below(edges: Sequence[float]) -> np.ndarray:
            return np.sum(self.ask(channel_below, row, np.asarray(edges, float)), axis=0)

        return Samples(size, low, high, below, lambda ranks: order_statistics(below, low, high, ranks))


def _is_given_up(question: Future) -> bool:
    return question.status == "error" and isinstance(question.exception(), KilledWorker)
