"""From records to Markdown."""

from collections import Counter
from collections.abc import Callable, Sequence

import numpy as np

from population.cases import PHENOMENA
from population.scoring import (
    Record,
    alarm,
    bootstrap,
    both,
    both_added,
    calibration,
    explained,
    first,
    groups,
    named,
    removed,
    renamed,
    restored,
    rough,
    skew_found,
    tied,
    unbiased,
    wilson,
)

LEVELS = ("weak", "medium", "strong")


def table(rows: Sequence[Sequence[object]]) -> str:
    """Markdown; the first row is the head, all columns except the first are numbers."""
    head, *body = [[str(cell) for cell in row] for row in rows]
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def share(values: Sequence[bool]) -> str:
    """``34 of 36: 94 % (86-98)``."""
    if not values:
        return "–"
    hits, count = sum(values), len(values)
    low, high = wilson(hits, count)
    return f"{hits} of {count}: {100 * hits / count:.0f} % ({100 * low:.0f}-{100 * high:.0f})"


def number(values: Sequence[float], figure: Callable = np.median, digits: int = 2) -> str:
    """A figure with its interval."""
    middle, low, high = bootstrap(values, figure)
    return "–" if np.isnan(middle) else f"{middle:.{digits}f} ({low:.{digits}f}-{high:.{digits}f})"


def report(records: Sequence[Record], seeds: Sequence[int]) -> str:
    """All tables."""
    done = [one for one in records if "failed" not in one]
    failed = [one for one in records if "failed" in one]
    kinds = Counter(one["kind"] for one in done)
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    which = f"seed{'s' * (len(seeds) > 1)} {', '.join(map(str, seeds))}"
    head = f"{len(done)} cases ({counts}), {which}; figures in brackets are 90 % intervals."
    head += "".join(f"\n- failed: {one['name']}: {one['failed']}" for one in failed)
    hidden = [one for one in done if one["kind"] == "hidden"]
    fair = [one for one in hidden if not rough(one)]
    sections = (
        ("Summary", summary(done)),
        ("How far to trust a finding, phenomenon by phenomenon", by_phenomenon(fair)),
        ("Confidence against truth", reliability([one for one in done if not rough(one)])),
        ("By damper, model, drive and rate", by_condition(fair)),
        ("Two at once", pairs([one for one in done if one["kind"] == "pair"])),
        ("Real recordings", real([one for one in done if one["kind"] == "real"])),
        ("Nothing hidden", alarms([one for one in done if not one["hidden"]])),
        ("All misses", misses(fair)),
        ("Seconds", seconds(done)),
    )
    return "\n\n".join([head, *(f"### {title}\n\n{text}" for title, text in sections if text)])


def summary(done: Sequence[Record]) -> str:
    """The figures with requirements on the diagnosis."""
    every = [one for one in done if one["kind"] == "hidden"]
    hidden = [one for one in every if not rough(one)]
    by_level = [[one for one in hidden if one["level"] == level] for level in LEVELS]
    by_level.append([one for one in hidden if one["level"] != "weak"])
    rows: list[list[object]] = [["", *LEVELS, "medium and strong"]]

    def add(words: str, figure: Callable[[Sequence[Record]], object]) -> None:
        rows.append([words, *(figure(cases) for cases in by_level)])

    add("hidden effect first", lambda cases: share([first(one) for one in cases]))
    add("in the first tied group", lambda cases: share([tied(one) for one in cases]))
    add("size of the group, mean", lambda cases: number([len(groups(one)[0]) for one in cases if groups(one)], np.mean))
    add("renamed", lambda cases: share([renamed(one) for one in cases]))
    add("called nothing_missing", lambda cases: share([one["verdict"] == "nothing_missing" for one in cases]))
    add("share of the excess removed, median", lambda cases: number([removed(one) for one in cases if "after" in one]))
    return table(rows) + "\n\n" + "\n".join(f"- {words}: {figure}" for words, figure in _more(done, every).items())


def _more(done: Sequence[Record], hidden: Sequence[Record]) -> dict[str, str]:
    nothing = [one for one in done if not one["hidden"]]
    pair = [one for one in done if one["kind"] == "pair" and not rough(one)]
    against = [one for one in pair if one["against"]]
    visible = [one for one in pair if one["shown"] * one["force_rms"] > one["base"]]
    skews = [one for one in hidden if one["hidden"] == ["channel_skew"] and not rough(one)]
    after = [one for one in done if "bias" in one and not set(one["hidden"]) & {"force_offset", "force_gain_error"}]
    off = [one for one in hidden if rough(one)]
    taken = [one for one in done if one["kind"] == "real" and one["forms"] == ["ablation"]]
    put = [one for one in done if one["kind"] == "real" and one["hidden"] and one["forms"] != ["ablation"]]
    return {
        "false alarms, nothing hidden": share([alarm(one) for one in nothing]),
        "... on real recordings": share([alarm(one) for one in nothing if one["kind"] == "real"]),
        "an effect named, nothing hidden": share([bool(one["findings"]) for one in nothing]),
        "... that leaves more than half of the squared error on unseen recordings": share(
            [bool(one["findings"]) and not explained(one) for one in nothing if "found_error" in one]
        ),
        "... on real recordings with their best model": share(
            [bool(one["findings"]) for one in nothing if one["kind"] == "real"]
        ),
        "squared error more than twice that of the identification as a share of the force, nothing hidden": share(
            [one["growth"][0] > 2.0 for one in nothing if "growth" in one]
        ),
        "... more than twice what is usual at the same speeds and frequencies": share(
            [one["growth"][1] > 2.0 for one in nothing if "growth" in one]
        ),
        "both of two named by diagnose": share([both(one) for one in pair]),
        "... added by improve": share([both_added(one) for one in pair if "steps" in one]),
        "... of those that act against each other, named": share([both(one) for one in against]),
        "... of those that change the force by more than the model errs, named": share([both(one) for one in visible]),
        "skew within 0.3 ms, or tied": share([skew_found(one) for one in skews]),
        "hidden in real recordings and first": share([first(one) for one in put]),
        "removed from the best model of real recordings and first": share([first(one) for one in taken]),
        "... what was found instead leaves no larger error": share(
            [restored(one) for one in taken if "found_error" in one]
        ),
        "error of users' models made by improve, without the effect, share of the force, median": number(
            [one["base"] / one["force_rms"] for one in done if "improve" in one["model"]], digits=3
        ),
        "expected calibration error": f"{calibration([one for one in done if not rough(one)])[1]:.3f}",
        "improved model unbiased (mean error below 2 % of the force)": share([unbiased(one) for one in after]),
        "excluded above: error of the user's model above the hidden effect; nevertheless first": share(
            [first(one) for one in off]
        ),
    }


def by_phenomenon(hidden: Sequence[Record]) -> str:
    """One row per hidden phenomenon."""
    rows: list[list[object]] = [["hidden", "first", "in group", "confidence, mean", "excess removed", "named instead"]]
    for name in PHENOMENA:
        cases = [one for one in hidden if one["hidden"] == [name]]
        if cases:
            sure = [one["findings"][0]["confidence"] for one in cases if one["findings"]]
            instead = Counter(named(one) for one in cases if not first(one))
            rows.append([
                name, share([first(one) for one in cases]), share([tied(one) for one in cases]),
                f"{np.mean(sure):.2f}" if sure else "–", number([removed(one) for one in cases if "after" in one]),
                ", ".join(f"{what} {count}" for what, count in instead.most_common()) or "–",
            ])  # fmt: skip
    return table(rows) if len(rows) > 1 else ""


def reliability(done: Sequence[Record]) -> str:
    """Mean confidence of first findings against their share of correct ones."""
    rows, _ = calibration(done)
    if not rows:
        return ""
    body = []
    for mean, right, count in rows:
        low, high = wilson(round(right * count), count)
        body.append([f"{mean:.2f}", f"{right:.2f} ({low:.2f}-{high:.2f})", count])
    return table([["confidence", "right", "findings"], *body])


def misses(hidden: Sequence[Record]) -> str:
    """All cases without the hidden effect in first place."""
    rows = [
        f"- {one['hidden'][0]} ({', '.join(one['forms'])}; {one['level']}, {one['family']}, {'/'.join(one['drive'])}, "
        f"{one['model']}): {said(one)}"
        f"; base {one['base']:.1f}, with it {one['before']:.1f} N of {one['force_rms']:.0f} N"
        for one in hidden
        if not first(one)
    ]
    return "\n".join(rows)


def said(one: Record) -> str:
    """All findings with their ties; the verdict without findings."""
    return "; ".join("/".join([finding["phenomenon"], *finding["tied_with"]]) for finding in one["findings"]) or named(
        one
    )


def by_condition(hidden: Sequence[Record]) -> str:
    """First places by all drawn conditions."""
    rows: list[list[object]] = [["", "first", "in group"]]
    keys: dict[str, Callable[[Record], object]] = {
        "damper": lambda one: one["family"],
        "model by": lambda one: one["model"].rpartition(" ")[0],
        "fit on": lambda one: one["drive"][0],
        "judged on": lambda one: "the same kind" if one["drive"][0] == one["drive"][1] else "another kind",
        "rate": lambda one: "up to 250 Hz" if one["rate"] <= 250 else "500 Hz" if one["rate"] == 500 else "1 to 3 kHz",
        "length": lambda one: "up to 40 s" if one["seconds"] <= 40 else "longer",
    }
    for words, key in keys.items():
        for value in sorted({key(one) for one in hidden}, key=str):
            cases = [one for one in hidden if key(one) == value]
            rows.append([f"{words} {value}", share([first(o) for o in cases]), share([tied(o) for o in cases])])
    return table(rows) if len(rows) > 1 else ""


def pairs(cases: Sequence[Record]) -> str:
    """Every pair."""
    rows: list[list[object]] = [["hidden", "forms", "named", "both"]]
    for one in cases:
        words = " against " if one["against"] else " + "
        rows.append([words.join(one["hidden"]), ", ".join(one["forms"]), said(one), "yes" if both(one) else "no"])
    return table(rows) if cases else ""


def real(cases: Sequence[Record]) -> str:
    """Every case on real recordings with a hidden effect."""
    rows: list[list[object]] = [["hidden", "how", "recordings", "model", "named", "error without it, with it"]]
    for one in cases:
        if one["hidden"]:
            errors = f"{one['base']:.1f}, {one['before']:.1f} N"
            rows.append([one["hidden"][0], one["forms"][0], one["family"], one["model"], said(one), errors])
    return table(rows) if len(rows) > 1 else ""


def alarms(cases: Sequence[Record]) -> str:
    """Every false alarm."""
    return "\n".join(
        f"- {one['family']}, {'/'.join(one['drive'])}, {one['model']}: {one['verdict']} "
        f"{named(one) if one['findings'] else ', '.join(one['moved'][:3])}; error {one['before']:.1f} N, "
        f"with it {one.get('found_error', np.nan):.1f} N, "
        f"on the base {one['own_base']:.1f} N, of {one['force_rms']:.0f} N"
        for one in cases
        if alarm(one)
    )


def seconds(done: Sequence[Record]) -> str:
    """Median and longest; processor time, as the machine can have other load."""
    rows = [["", "cases", "median", "90 % below", "longest"]]
    for name in (
        "simulate_seconds",
        "model_seconds",
        "diagnose_seconds",
        "diagnose_cpu",
        "improve_seconds",
        "improve_cpu",
    ):
        values = [one[name] for one in done if name in one]
        if values:
            figures = (np.median(values), np.quantile(values, 0.9), max(values))
            rows.append([name.replace("_", ", "), str(len(values)), *(f"{value:.1f}" for value in figures)])
    return table(rows)


def line(record: Record) -> str:
    """A case in one line."""
    if "failed" in record:
        return f"{record['name']}: FAILED {record['failed']}"
    found = "; ".join(
        "/".join([one["phenomenon"], *one["tied_with"]]) + f" {one['confidence']:.2f}" for one in record["findings"]
    )
    more = f" -> {record['after']:.1f}, {record['improve_seconds']:.0f} s" if "after" in record else ""
    return (
        f"{record['name']} ({', '.join(record['forms'])}) {record['family']}, {record['model']}: "
        f"{record['verdict']} {found}"
        f" | base {record['base']:.1f}, {record['before']:.1f}{more} of {record['force_rms']:.0f} N"
        f" | {record.get('diagnose_seconds', record['all_cpu']):.0f} s"
    )
