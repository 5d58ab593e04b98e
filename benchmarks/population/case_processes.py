"""Runs cases, each in a separate process with a time limit; every completed case is saved as a line of JSON."""

import json
import resource
import signal
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from multiprocessing import get_context
from pathlib import Path
from time import monotonic
from typing import Any

from population.cases import Card

_CONTEXT = get_context("spawn")

PATIENCE = 6.0
"""Longest wall time of a case over its limit of processor time."""


class TooLong(Exception):
    """A case exceeded its time limit."""


@dataclass(frozen=True)
class Order:
    """Options for judging cases: ``folder`` for recordings and models, ``limit`` in s of processor time per case,
    ``given`` a folder of cases from elsewhere, None for drawn ones.
    """

    seed: int
    folder: Path
    improving: bool
    limit: float
    given: Path | None = None


def results(cards: Sequence[Card], order: Order, workers: int, place: Path) -> Iterator[dict[str, Any]]:
    """Records on completion, written to ``place`` one by one."""
    waiting, running = list(reversed(cards)), []
    while waiting or running:
        while waiting and len(running) < workers:
            running.append(_Running(waiting.pop(), order))
        for one in list(running):
            record = one.result()
            if record is None:
                continue
            running.remove(one)
            with place.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(record) + "\n")
            yield record


def done(place: Path) -> dict[str, dict[str, Any]]:
    """Records of an earlier run by the case's name; the last of each, without failures."""
    if not place.exists():
        return {}
    lines = (json.loads(text) for text in place.read_text(encoding="utf-8").splitlines() if text.endswith("}"))
    return {record["name"]: record for record in lines if "failed" not in record}


class _Running:
    """One case in its process."""

    def __init__(self, card: Card, order: Order) -> None:
        # Other load on the machine must not count.
        self.card, self.began, self.limit = card, monotonic(), PATIENCE * order.limit
        self.end, other = _CONTEXT.Pipe(duplex=False)
        self.process = _CONTEXT.Process(target=_one, args=(card, order, other), daemon=True)
        self.process.start()
        other.close()

    def result(self) -> dict[str, Any] | None:
        """The record when available; waits for at most a fifth of a second."""
        if self.end.poll(0.2):
            try:
                record = self.end.recv()
            except EOFError:
                record = self._failed("the process died")
            self.process.join()
            return record
        if monotonic() - self.began < self.limit:
            return None
        self.process.kill()
        self.process.join()
        return self._failed(f"took longer than {self.limit:g} s")

    def _failed(self, why: str) -> dict[str, Any]:
        return facts(self.card) | {"failed": why}


def facts(card: Card) -> dict[str, Any]:
    """The known facts of a case before its simulation."""
    return {"name": card.name, "kind": card.kind, "hidden": list(card.hidden), "level": card.level}


def _limit(seconds: float) -> None:
    """Stops this process after ``seconds`` of processor time."""

    def stop(number: int, frame: object) -> None:
        raise TooLong(f"needed more than {seconds:g} s of processor time")

    signal.signal(signal.SIGXCPU, stop)
    soft = ceil(seconds)
    resource.setrlimit(resource.RLIMIT_CPU, (soft, soft + 60))


def _one(card: Card, order: Order, end: Any) -> None:
    try:
        _limit(order.limit)
        from population.case_records import record

        found = record(card, order.seed, order.folder, order.improving, order.given)
    except Exception as fault:  # a failed case counts and must not end the run
        found = facts(card) | {"failed": f"{type(fault).__name__}: {fault}", "traceback": traceback.format_exc()}
    end.send(found)
