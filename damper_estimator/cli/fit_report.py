"""The results of ``fit`` as text."""

from pathlib import Path

from damper_estimator.identification import Fit, FittedParameter, Front, JointFit
from damper_estimator.identification.pareto_front import BEST
from damper_estimator.numbers import plus_minus

_ERROR, _COLUMN = 22, 34  # characters of an error, and of a value with it


def table(damper: str, result: Fit, target: Path) -> str:
    """The results as text."""
    width = max(len(parameter.name) for parameter in result.parameters)
    knots = result.model.knots
    lines = [f"{damper}: {result.model.name}, {len(result.parameters)} parameters, {result.samples} judged samples"]
    for p in result.parameters:
        unit = p.unit if p.unit != "1" else ""
        row = f"  {p.name:<{width}}  {p.value:>12.6g} {_uncertainty(p):<{_ERROR}}  {unit} {knots.get(p.name, '')}"
        lines.append(row.rstrip())
    lines += [
        f"  rms error  {result.rmse_before_n:.4g} N -> {result.rmse_n:.4g} N",
        f"  ESR        {result.esr_before:.4g} -> {result.esr:.4g}",
        *(f"  note: {warning}" for warning in result.warnings),
        *([] if result.front is None else _front_lines(result.front, target)),
        f"  {result.seconds:.1f} s, {result.evaluations} evaluations; written to {target}",
    ]
    return "\n".join(lines)


def _uncertainty(parameter: FittedParameter) -> str:
    if parameter.at_bound:
        return "at its bound"
    return plus_minus(parameter.value, parameter.standard_error)


def _front_lines(front: Front, target: Path) -> list[str]:
    """Corners of the front, and the parameters of each group's best solutions."""
    width = max(map(len, (*front.groups, "knee")))
    counts = ", ".join(f"{group} {n}" for group, n in zip(front.groups, front.excitations, strict=False))
    lines = [f"  front of {len(front.values)} points, excitations by group: {counts or 'as before'}"]
    for name in ("knee", *front.groups):
        row = front.row(name)
        errors = "  ".join(f"{g} {e:.3g}" for g, e in zip(front.groups, front.objectives[row], strict=True))
        mark = "  <- selected" if row == front.picked else ""
        lines.append(f"    {name:<{width}}  point {row:<4} error relative to the start: {errors}{mark}")
    regimes = front.regimes()
    lines.append(f"  parameters of the {min(BEST, len(front.values))} best per group, mean and standard deviation")
    wide = max(map(len, front.names))
    lines.append("    " + " " * wide + "".join(f"{group:>24}" for group in front.groups))
    for name in front.names:
        cells = [f"{regimes[g][name]['mean']:.4g} ± {regimes[g][name]['stddev']:.2g}" for g in front.groups]
        lines.append(f"    {name:<{wide}}" + "".join(f"{cell:>24}" for cell in cells))
    return [*lines, f"  all points: {target.with_suffix('.front.csv')}; --pick and --front select another one"]


def joint_table(damper: str, result: JointFit, folder: Path) -> str:
    """A joint fit as text: shared parameters once, others side by side by setting."""
    first = next(iter(result.fits.values()))
    shared = [p for p in result.parameters if "@" not in p.name]
    width = max(len(p.name) for p in first.parameters)
    lines = [f"{damper}: {first.model.name}, {len(result.parameters)} parameters, {len(result.fits)} settings"]
    lines += [f"  {p.name:<{width}}  {p.value:>12.6g} {_uncertainty(p):<{_ERROR}}  {p.unit}".rstrip() for p in shared]
    lines.append(f"  {'by setting':<{width}}" + "".join(f"{name:>{_COLUMN}}" for name in result.fits))
    for address in (p.name for p in first.parameters if p.name in result.each):
        parameters = [next(p for p in fit.parameters if p.name == address) for fit in result.fits.values()]
        lines.append(
            f"  {address:<{width}}" + "".join(f"{f'{p.value:.6g} {_uncertainty(p)}':>{_COLUMN}}" for p in parameters)
        )
    before = "".join(f"{f'{fit.esr_before:.3g} -> {fit.esr:.3g}':>{_COLUMN}}" for fit in result.fits.values())
    lines += [f"  {'ESR':<{width}}{before}", *(f"  note: {warning}" for warning in result.warnings)]
    return "\n".join([*lines, f"  {first.seconds:.1f} s, {first.evaluations} evaluations; written to {folder}"])
