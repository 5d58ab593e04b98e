"""The tables of the hidden-effect bench: from the records of its cases to Markdown."""

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from hidden_plans import MEDIUM, STRONG, WEAK
from hidden_verdicts import (
    both_found,
    first_group,
    first_named,
    groups,
    improved_by,
    median,
    multiple,
    removed,
    share,
    skew_recovered,
)

from damper_estimator.plant import PHENOMENA

LEVELS = {"weak": WEAK, "medium": MEDIUM, "strong": STRONG}
OTHERWISE = ("nothing_missing", "parameters_changed", "unexplained")
REMOVED = 0.75  # of the excess

Record = dict[str, Any]


def report(records: Sequence[Record], seconds: float, processes: int, new: int) -> str:
    """All tables; ``seconds`` is the duration of the ``new`` cases."""
    done = [one for one in records if "failed" not in one]
    failed = [one for one in records if "failed" in one]
    hidden = [one for one in done if one["kind"] == "hidden"]
    medium = [one for one in hidden if one["wanted"] == MEDIUM]
    kinds = {kind: [one for one in done if one["kind"] == kind] for kind in ("pair", "nothing", "skew")}
    sections = (
        ("Summary", _summary, done),
        ("By phenomenon, medium strength", _by_phenomenon, medium),
        ("Hidden effect (rows) and first finding (columns), all strengths", confusion, hidden),
        ("By damper, excitation and strength", _by_condition, hidden),
        ("Two at once", _pairs, kinds["pair"]),
        ("Nothing hidden", _alarms, kinds["nothing"]),
        ("Skew", _skews, kinds["skew"]),
        ("All misses at medium strength", _misses, medium),
    )
    written = [f"### {title}\n\n{make(cases)}" for title, make, cases in sections if cases]
    return "\n\n".join([_head(done, failed, seconds, processes, new), *written])


def table(rows: Sequence[Sequence[object]]) -> str:
    """Markdown; the first row is the head, all columns except the first are numbers."""
    head, *body = [[str(cell) for cell in row] for row in rows]
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _head(done: Sequence[Record], failed: Sequence[Record], seconds: float, processes: int, new: int) -> str:
    kinds = Counter(one["kind"] for one in done)
    counts = ", ".join(f"{kinds[kind]} {kind}" for kind in ("hidden", "nothing", "pair", "skew"))
    judging = sum(one.get("improve_seconds", 0.0) + one.get("diagnose_seconds", 0.0) for one in done) / 60.0
    words = f"{len(done)} cases ({counts}), judged in {judging:.0f} minutes of one core"
    if new:
        words += f"; {new} of them now, in {seconds / 60.0:.0f} minutes on {processes} processes"
    words += "."
    return words + "".join(f"\n- failed: {one['name']}: {one['failed']}" for one in failed)


def _summary(done: Sequence[Record]) -> str:
    rows: list[list[object]] = [["", *LEVELS, "all"]]
    hidden = [one for one in done if one["kind"] == "hidden"]
    by_level = [[one for one in hidden if one["wanted"] == level] for level in LEVELS.values()] + [hidden]

    def add(words: str, figure: Callable[[Sequence[Record]], object]) -> None:
        rows.append([words, *(figure(cases) if cases else "–" for cases in by_level)])

    add("hidden effect in first place", lambda cases: share([_right(one) for one in cases]))
    add(
        "... and no other effect tied with it",
        lambda cases: share([_right(one) and len(first_group(one)) == 1 for one in cases]),
    )
    add(
        "... and the verdict is `missing`",
        lambda cases: share([_right(one) and one["verdict"] == "missing" for one in cases]),
    )
    add("in the first tied group", lambda cases: share([one["phenomena"][0] in first_group(one) for one in cases]))
    add("group size, mean / largest", _group_size)
    add("missed: nothing_missing", lambda cases: share([one["verdict"] == "nothing_missing" for one in cases]))
    add(
        "renamed: another effect named, the hidden one not in its group",
        lambda cases: share([_renamed(one) for one in cases]),
    )
    add(
        f"`improve` removed {100 * REMOVED:.0f} % of the excess",
        lambda cases: share([removed(one) >= REMOVED for one in cases]),
    )
    add("share of the excess removed, median", lambda cases: f"{median([removed(one) for one in cases]):.2f}")
    add(
        "unseen error over force rms, before",
        lambda cases: _percent([one["before"] / one["force_rms"] for one in cases]),
    )
    add("... after", lambda cases: _percent([one["after"] / one["force_rms"] for one in cases]))
    add("error left over noise floor, median", lambda cases: f"{median([multiple(one) for one in cases]):.2f}")
    nothing = [one for one in done if one["kind"] == "nothing"]
    pairs = [one for one in done if one["kind"] == "pair"]
    skews = [one for one in done if one["kind"] == "skew"]
    more = [
        f"- false alarms, nothing hidden: {share([one['verdict'] != 'nothing_missing' for one in nothing])}",
        f"- both of two found by `diagnose`: {share([both_found(groups(one), one['phenomena']) for one in pairs])}; "
        f"added by `improve`: {share([both_found(improved_by(one), one['phenomena']) for one in pairs])}",
        f"- skew within 0.3 ms and not tied: {share([skew_recovered(one) for one in skews])}",
        f"- seconds on one core, median / longest: `diagnose` {_spread(done, 'diagnose_seconds')}, "
        f"`improve` {_spread(done, 'improve_seconds')}; memory of one process at most "
        f"{max((one['memory_mb'] for one in done), default=float('nan')):.0f} MB",
    ]
    return table(rows) + "\n\n" + "\n".join(more)


def _right(one: Record) -> bool:
    return first_named(one) == one["phenomena"][0]


def _renamed(one: Record) -> bool:
    return bool(one["findings"]) and one["phenomena"][0] not in first_group(one)


def _percent(values: Sequence[float]) -> str:
    return f"{100.0 * median(values):.1f} %"


def _group_size(cases: Sequence[Record]) -> str:
    sizes = [len(group) for one in cases for group in groups(one)[:1]]
    return f"{np.mean(sizes):.2f} / {max(sizes)}" if sizes else "–"


def _spread(done: Sequence[Record], key: str) -> str:
    values = [one[key] for one in done if key in one]
    return f"{median(values):.1f} / {max(values):.1f}" if values else "–"


def _by_phenomenon(medium: Sequence[Record]) -> str:
    rows: list[list[object]] = [
        ["hidden", "cases", "first", "in group", "group size", "named instead", "excess removed", "error before",
         "after", "over floor"],
    ]  # fmt: skip
    for name in PHENOMENA:
        cases = [one for one in medium if one["phenomena"] == [name]]
        if not cases:
            continue
        instead = Counter(first_named(one) for one in cases if not _right(one))
        rows.append([
            name,
            len(cases),
            sum(_right(one) for one in cases),
            sum(name in first_group(one) for one in cases),
            _group_size(cases),
            ", ".join(f"{what} {count}" for what, count in instead.most_common()) or "–",
            f"{median([removed(one) for one in cases]):.2f}",
            _percent([one["before"] / one["force_rms"] for one in cases]),
            _percent([one["after"] / one["force_rms"] for one in cases]),
            f"{median([multiple(one) for one in cases]):.2f}",
        ])  # fmt: skip
    return table(rows)


def confusion(hidden: Sequence[Record]) -> str:
    """The matrix; columns are numbered like the rows."""
    names = list(PHENOMENA)
    columns = [*names, *OTHERWISE]
    heads = [str(number + 1) for number in range(len(names))] + ["nothing", "changed", "unexplained"]
    rows: list[list[object]] = [["hidden", *heads]]
    for number, name in enumerate(names):
        count = Counter(first_named(one) for one in hidden if one["phenomena"] == [name])
        cells = [f"**{count[what]}**" if what == name else count[what] or "" for what in columns]
        rows.append([f"{number + 1} {name}", *cells])
    return table(rows)


def _by_condition(hidden: Sequence[Record]) -> str:
    rows: list[list[object]] = [["", "cases", "first", "in group", "removed enough", "over floor"]]
    conditions: list[tuple[str, Callable[[Record], object]]] = [
        ("damper", lambda one: one["damper"]),
        ("fit on", lambda one: one["excitation"]),
        (
            "judged on",
            lambda one: "another excitation" if one["excitation"] != one["unseen_excitation"] else "the same",
        ),
        ("strength", lambda one: f"{100 * one['wanted']:.0f} %"),
    ]
    for words, key in conditions:
        for value in sorted({key(one) for one in hidden}):
            cases = [one for one in hidden if key(one) == value]
            rows.append([
                f"{words} {value}",
                len(cases),
                f"{100 * np.mean([_right(one) for one in cases]):.0f} %",
                f"{100 * np.mean([one['phenomena'][0] in first_group(one) for one in cases]):.0f} %",
                f"{100 * np.mean([removed(one) >= REMOVED for one in cases]):.0f} %",
                f"{median([multiple(one) for one in cases]):.2f}",
            ])  # fmt: skip
    return table(rows)


def _pairs(cases: Sequence[Record]) -> str:
    rows: list[list[object]] = [
        ["hidden", "damper, excitation", "found, best first", "`improve`", "excess removed", "over floor"]
    ]
    for one in cases:
        found = "; ".join("/".join([f["phenomenon"], *f["tied_with"]]) for f in one["findings"]) or one["verdict"]
        steps = ", ".join(what for group in improved_by(one) for what in sorted(group)) or "–"
        rows.append([
            " + ".join(one["phenomena"]),
            f"{one['damper']}, {one['excitation']}",
            found,
            steps,
            f"{removed(one):.2f}",
            f"{multiple(one):.2f}",
        ])  # fmt: skip
    return table(rows)


def _alarms(cases: Sequence[Record]) -> str:
    alarms = [one for one in cases if one["verdict"] != "nothing_missing"]
    words = f"{share([one['verdict'] != 'nothing_missing' for one in cases])} raised an alarm."
    return words + "".join(
        f"\n- {one['damper']}, {one['excitation']} / {one['unseen_excitation']}: {first_named(one)}"
        f"{'' if one['findings'] else ' ' + ', '.join(one['moved'][:4])}, "
        f"error {one['before']:.1f} N, floor {one['floor']:.1f} N"
        for one in alarms
    )


def _skews(cases: Sequence[Record]) -> str:
    rows: list[list[object]] = [["injected", "random", "road"]]
    for skew in sorted({one["true_skew"] for one in cases}):
        cells = [
            "; ".join(
                f"{1e3 * one['skew']:+.2f}" + ("" if first_group(one) == {"channel_skew"} else f" ({_said(one)})")
                for one in cases
                if one["true_skew"] == skew and one["excitation"] == excitation
            )
            for excitation in ("random", "road")
        ]
        rows.append([f"{1e3 * skew:+.1f} ms", *cells])
    return table(rows)


def _said(one: Record) -> str:
    return "/".join([first_named(one), *sorted(first_group(one) - {first_named(one)})])


def _misses(medium: Sequence[Record]) -> str:
    rows = [
        f"- {one['phenomena'][0]}: {_said(one)} ({one['damper']}, {one['excitation']} / {one['unseen_excitation']})"
        for one in medium
        if not _right(one)
    ]
    return "\n".join(rows) or "none"
