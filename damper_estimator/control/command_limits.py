"""The commands that may be sent to a damper: those of its driver within the region of its model's fit."""

from damper_estimator.errors import InputError
from damper_estimator.runtime import Deployed
from damper_estimator.signals.layout import COMMAND


def usable_limits(
    name: str, deployed: Deployed, extrapolating: bool = False
) -> tuple[tuple[float, float] | None, tuple[str, ...]]:
    """The lowest and the highest command that may be sent (SI; None: those of the fit), and notes for the user.

    Args:
        name: of the damper, for messages.
        extrapolating: whether the driver's limits apply outside the region of the fit as well.

    Raises:
        InputError: one line, where the driver's limits and the region of the fit have nothing in common.
    """
    given, (low, high) = deployed.signals.command.value_limits, map(float, deployed.bounds[COMMAND])
    if given is None:
        return None, ()
    unit = deployed.signals.command.unit or "A"
    region = f"region {low:g} to {high:g} {unit} that the model was fitted on"
    limits = max(given[0], low), min(given[1], high)
    if not limits[0] < limits[1]:
        raise InputError(
            f"{name}: the limits {given[0]:g} to {given[1]:g} {unit} of the command have nothing in common with the "
            f"{region}; correct the limits in the signal map, or fit the model to recordings within them"
        )
    if extrapolating or limits == given:
        return given, ()
    return limits, (f"currents are kept within the {region}; the driver's limits reach beyond",)
