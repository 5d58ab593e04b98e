"""The atlas as curves: by how much a damper's force differs from a model's, over each variable given the others.

    F_measured - F_model = dF(v) + h(x) + p(x) F_model + g(v) (T - T_0) + b(v) (I - I_0) + m(v) a
                           + o(v) sign(v a) / 2 + r(travel since the last reversal) sign(v) + rest

All curves are piecewise linear and solved for together on the fitted rows, so that each holds given the others. Their
covariance allows for the memory of the rest; as in the form-free tests, the only regularisation limits the share of
one column to the order of the force. The last two curves, of memory, have the columns of the form-free tests that are
called like them. They and the others imitate each other in part, so that they count only by what they explain beyond
these, and are left out where that is nothing.
"""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from statistics import NormalDist

import numpy as np

from damper_estimator.diagnosis.acceleration_templates import Template, templates_of
from damper_estimator.diagnosis.atlas_terms import View, views
from damper_estimator.diagnosis.baseline import Baseline
from damper_estimator.diagnosis.curve_panels import Panel, panels_of
from damper_estimator.diagnosis.curve_regression import Moments, Regression
from damper_estimator.diagnosis.diagnosis_data import targets
from damper_estimator.files import plain
from damper_estimator.identification.rows import Rows, split
from damper_estimator.numerics import score_covariance

_LEAST_SEEN = 1e-3  # of the columns' largest rms: below, nothing is known at a knot
_LEAST_LEFT = 0.2  # of the effective samples: so many are not spent on the columns
_BAND = NormalDist().inv_cdf(0.95)
_WORTH = 0.02  # of the squared error: what a curve must explain to be shown
_CHANCE = 0.05  # that a curve is clear where there is nothing


@dataclass(frozen=True)
class AtlasCurve:
    """One curve of what a model lacks; SI units.

    Attributes:
        name: ``velocity``: change of the force over velocity, N over m/s, about its mean near rest. ``displacement``:
            of the force over displacement, N over m, about its mean. ``position``: the same as a share of the model's
            force. ``temperature``, ``command``: change of the force per kelvin or ampere, over velocity.
            ``acceleration``: coefficient of acceleration over velocity, kg. ``history``: force at rising less that at
            falling speed, N over m/s. ``memory``: force in the direction of motion after a reversal less that after a
            long travel, N over m of the travel since then.
        at: (k,) values of its variable; straight lines connect the points.
        value, low, high: (k,) with the ends of its band, 5 and 95 %; NaN where too little was driven.
        explains: share of the squared error on unseen data that all other curves leave and it explains. Curves of
            memory are no others for the rest, which loses to them what they explain better.
        is_clear: whether it differs from zero by more than chance.
        templates: what it may be, the one that explains most first.
    """

    name: str
    at: tuple[float, ...]
    value: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    explains: float
    is_clear: bool
    templates: tuple[Template, ...] = ()

    @property
    def is_notable(self) -> bool:
        """Whether it says something: it differs from zero and explains some of the error."""
        return self.is_clear and self.explains >= _WORTH

    @property
    def is_memory(self) -> bool:
        """Whether it is a curve of memory, which counts only by what it explains beyond the others."""
        return self.name in ("history", "memory")

    def record(self) -> dict[str, object]:
        """For JSON; None where nothing is known."""
        return plain(asdict(self))


@dataclass(frozen=True)
class _Together:
    """All curves in one regression.

    Attributes:
        panel_of: (c,) int, the panel of each column.
        whole: the regression by all columns, each scaled to the rms of the force.
        columns, missing: (r, c) the same on the fitted rows, and (r,) what they are to explain.
        mixed: (c, c) points of the curves per coefficient.
        scale: (c,) the factor of each column; 0 where it is left out.
    """

    panels: Sequence[Panel]
    panel_of: np.ndarray
    whole: Regression
    columns: np.ndarray
    missing: np.ndarray
    mixed: np.ndarray
    scale: np.ndarray
    rows: Sequence[Rows]
    seen: Sequence[View]

    def without(self, dropped: np.ndarray) -> "_Together":
        """With some columns (c,) bool left out."""
        return replace(
            self, whole=self.whole.mixed(np.diag((~dropped).astype(float))), scale=np.where(dropped, 0.0, self.scale)
        )

    def of_panels(self, chosen: Callable[[Panel], bool]) -> np.ndarray:
        """(c,) bool, the columns of the panels that are chosen."""
        return np.array([chosen(self.panels[index]) for index in self.panel_of])

    def curves(self) -> list[AtlasCurve]:
        """All that have columns."""
        solution, values, deviations = self._solution()
        memory, found = self.of_panels(lambda panel: panel.is_memory), []
        for index, panel in enumerate(self.panels):
            own = self.panel_of == index
            if not self.scale[own].any():
                continue
            value = np.where(self.scale[own] > 0.0, values[own], np.nan)
            beside = ~own if panel.is_memory else ~own & ~memory
            gain, drawn = _explained(self.whole, solution, own, beside)
            curve = _curve(panel, value, deviations[own], drawn * gain)
            if panel.name == "acceleration":
                templates = templates_of(self.whole, own, beside, self.scale, panel.at, self.seen)
                curve = replace(curve, templates=tuple(replace(t, explains=drawn * t.explains) for t in templates))
            found.append(curve)
        return found

    def _solution(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coefficients (c,), the points (c,) of all curves, and the standard errors of these."""
        solution, inverse = self.whole.solved()
        scores = self.columns @ (inverse @ self.mixed.T)
        left, rows = self.missing - self.columns @ solution, self.rows
        covariance, effective = score_covariance(split(rows, left), split(rows, scores), [part.rate for part in rows])
        spent = effective / max(effective - np.count_nonzero(self.scale), _LEAST_LEFT * effective)
        return solution, self.mixed @ solution, np.sqrt(np.diag(covariance) * spent)


def atlas_curves(baseline: Baseline) -> tuple[AtlasCurve, ...]:
    """All curves that the recordings allow, with the model's parameters kept; none where its force runs away."""
    together = _together(baseline)
    if not together.whole.is_finite:
        return ()
    together = together.without(_harmful(together))
    curves = {curve.name: curve for curve in together.curves()}
    # A curve of memory that says nothing would only take from the others what it can imitate.
    quiet = {name for name, curve in curves.items() if curve.is_memory and not curve.is_notable}
    if quiet:
        again = together.without(together.of_panels(lambda panel: panel.name in quiet))
        curves |= {curve.name: curve for curve in again.curves()}
    return tuple(curves.values())


def _together(baseline: Baseline) -> _Together:
    data, missing = baseline.data, -baseline.residual_fit
    seen, judged = (views(baseline.model, rows, data.ranges) for rows in (data.fit, data.unseen))
    panels = panels_of(seen, judged, data.ranges)
    mixed = _about_means([panel.mean for panel in panels])
    columns, unseen = (_rows(rows, of, panels) for rows, of in ((data.fit, seen), (data.unseen, judged)))
    panel_of = np.repeat(np.arange(len(panels)), [panel.at.size for panel in panels])
    scale = _scales(columns @ mixed, panel_of, float(np.sqrt(np.mean(targets(data.fit) ** 2))))
    mixed = mixed * scale
    columns, unseen = columns @ mixed, unseen @ mixed
    whole = Regression(
        Moments.of(columns, missing), Moments.of(unseen, -baseline.residual_unseen), float(np.mean(missing**2))
    )
    return _Together(panels, panel_of, whole, columns, missing, mixed, scale, data.fit, seen)


def _rows(rows: Sequence[Rows], seen: Sequence[View], panels: Sequence[Panel]) -> np.ndarray:
    """(r, c) columns of all curves."""
    groups = ((column for panel in panels for column in panel.columns(view)) for view in seen)
    return np.concatenate([one.of_columns(group) for one, group in zip(rows, groups, strict=True)])


def _scales(rows: np.ndarray, panel_of: np.ndarray, size: float) -> np.ndarray:
    """(c,) factors that give each column (r, c) the rms ``size``; 0 where next to nothing was driven."""
    rms = np.sqrt(np.mean(rows**2, axis=0))
    largest = np.array([rms[panel_of == index].max() for index in panel_of])
    return np.where(rms > _LEAST_SEEN * largest, size / np.maximum(rms, 1e-300), 0.0)


def _harmful(together: _Together) -> np.ndarray:
    """(c,) bool: columns of slow variables that do harm, as where the unseen part is warmer than the fitted one."""
    found, whole = np.zeros(together.panel_of.size, bool), together.whole
    for index, panel in enumerate(together.panels):
        own = together.panel_of == index
        if panel.is_slow and whole.mixed(np.eye(own.size)[:, ~own]).left < whole.left:
            found |= own
    return found


def _about_means(means: Sequence[np.ndarray]) -> np.ndarray:
    """(c, c) that takes the mean of each curve, weights (k,), from its coefficients."""
    owner = np.repeat(np.arange(len(means)), [mean.size for mean in means])
    return np.eye(owner.size) - (owner[:, None] == owner) * np.concatenate(means)


def _explained(whole: Regression, solution: np.ndarray, own: np.ndarray, beside: np.ndarray) -> tuple[float, float]:
    """What a curve, columns ``own`` (c,) bool, explains beside some others, and how much of it the curve still has
    where all are found together: a curve of memory takes away what it explains better.
    """
    columns = np.eye(own.size)
    without = whole.mixed(columns[:, beside | own])
    alone = columns[:, beside | own] @ without.solved()[0]
    before, after = (whole.power_of(found * own) for found in (alone, solution))
    return whole.mixed(columns[:, beside]).gain(without.left), min(after / max(before, 1e-300), 1.0)


def _curve(panel: Panel, value: np.ndarray, deviation: np.ndarray, explains: float) -> AtlasCurve:
    known = np.isfinite(value)
    far = NormalDist().inv_cdf(1.0 - 0.5 * _CHANCE / max(np.count_nonzero(known), 1))
    return AtlasCurve(
        name=panel.name,
        at=tuple(panel.at.tolist()),
        value=tuple(value.tolist()),
        low=tuple((value - _BAND * deviation).tolist()),
        high=tuple((value + _BAND * deviation).tolist()),
        explains=explains,
        is_clear=bool(np.any(np.abs(value[known]) > far * deviation[known])),
    )
