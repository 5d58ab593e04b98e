"""The page of a Pareto front: the objectives two by two, with the chosen point, and what is best for each group."""

from collections.abc import Mapping, Sequence

import numpy as np

from damper_estimator.report.page import render


def front_page(
    model: str,
    groups: Sequence[str],
    objectives: np.ndarray,
    picked: int,
    regimes: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> str:
    """The whole page as HTML; it needs nothing else, no network either.

    Args:
        model: its name.
        groups: names of the objectives.
        objectives: (k, g), squared error relative to that of the start.
        picked: row that became the model.
        regimes: by group and parameter, ``mean`` and ``stddev`` over the solutions that are best for the group.
    """
    pairs = [(a, b) for b in range(len(groups)) for a in range(b)]
    corners = [int(np.argmin(objectives[:, k])) for k in range(len(groups))]
    names = list(next(iter(regimes.values())))
    rows = [
        [name, *(f"{regimes[group][name]['mean']:.4g} ± {regimes[group][name]['stddev']:.2g}" for group in groups)]
        for name in names
    ]
    shares = [", ".join(f"{group} {value:.3g}" for group, value in zip(groups, own, strict=True)) for own in objectives]
    section = {
        "damper": model,
        "headline": f"{len(objectives)} solutions, none better than another for every group. Point {picked} became the "
        f"model: squared error relative to the start {shares[picked]}.",
        "groups": groups,
        "pairs": len(pairs),
        "pair_names": [f"{groups[b]} over {groups[a]}" for a, b in pairs],
        "rows": rows,
    }
    figure = {
        "groups": list(groups),
        "pairs": pairs,
        "objectives": np.maximum(objectives, 1e-9).T.tolist(),
        "picked": picked,
        "corners": corners,
    }
    return render("front.html", f"Pareto front of {model}", [section], ["page.css"], "front.js", [figure])
