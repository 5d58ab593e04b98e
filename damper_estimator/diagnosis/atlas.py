"""An atlas of a model's error: on which variables it depends, before any effect's form is assumed.

    residual = sum_k c_k term_k + rest,      c found on the fitted rows, judged on the unseen ones

The only regularisation limits the coefficient of a column to the order of the force.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from damper_estimator.diagnosis.atlas_terms import TESTS, Columns, Test, views
from damper_estimator.diagnosis.diagnosis_data import DiagnosisData, targets
from damper_estimator.identification.rows import Rows
from damper_estimator.model import DamperModel


@dataclass(frozen=True)
class Terms:
    """One test on the data.

    Attributes:
        fit, unseen: (r, k) rows of its columns, each scaled to the rms of the measured force.
    """

    test: Test
    fit: np.ndarray
    unseen: np.ndarray


def terms(model: DamperModel, data: DiagnosisData, tests: Sequence[Test] = TESTS) -> list[Terms]:
    """The tests that these recordings allow."""
    fit, unseen = (views(model, rows, data.ranges) for rows in (data.fit, data.unseen))
    size = float(np.sqrt(np.mean(targets(data.fit) ** 2)))
    found = []
    for test in tests:
        seen = [test.columns(view) for view in (*fit, *unseen)]
        if any(columns is None for columns in seen):
            continue
        first = _rows(data.fit, seen[: len(fit)])
        scale = np.sqrt(np.mean(first**2, axis=0))
        useful = scale > 1e-9 * max(scale.max(), 1e-300)
        scale = size / scale[useful]
        found.append(Terms(test, first[:, useful] * scale, _rows(data.unseen, seen[len(fit) :])[:, useful] * scale))
    return found


def _rows(rows: Sequence[Rows], columns: Sequence[Columns]) -> np.ndarray:
    return np.concatenate([one.of_columns(group) for one, group in zip(rows, columns, strict=True)])
