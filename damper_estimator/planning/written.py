"""A plan as files: the drive as comma-separated values, and the whole plan as YAML."""

from collections.abc import Mapping, Sequence

import numpy as np
import yaml

from damper_estimator.files import plain
from damper_estimator.planning.result import Plan


def drive_csv(plan: Plan) -> str:
    """The drive as text: time in s, displacement in m, and current and temperature where the test sets them."""
    rate, samples = plan.limits.rate, plan.displacement.size
    columns = {"time_s": np.arange(samples) / rate, "displacement_m": plan.displacement}
    for name, field in (("current_a", "current"), ("temperature_deg_c", "temperature")):
        values = [getattr(step, field) for step in plan.steps]
        if any(value is not None for value in values):
            columns[name] = _through(plan, [np.nan if value is None else value for value in values])
    lines = [",".join(columns)]
    lines += [
        ",".join((f"{row[0]:.6f}", *(f"{value:.9f}" for value in row[1:])))
        for row in zip(*columns.values(), strict=True)
    ]
    return "\n".join(lines) + "\n"


def _through(plan: Plan, values: Sequence[float]) -> np.ndarray:
    """(n,) the value of each step over the whole drive; the rests have that of their neighbour."""
    sizes = [step.displacement.size for step in plan.steps]
    inner = np.repeat(values, sizes)
    first = plan.rest_samples
    return np.pad(inner, (first, plan.displacement.size - first - inner.size), mode="edge")


def plan_yaml(plan: Plan, asked: Mapping[str, object]) -> str:
    """The plan as YAML, in the order in which it is read."""
    text: str = yaml.safe_dump(plain({**asked, **plan.record()}), sort_keys=False, allow_unicode=True, width=120)
    return text
