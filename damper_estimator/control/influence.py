"""Whether a model's force depends on the command, and in which range: determined from its behaviour, not its parts."""

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import DamperModel
from damper_estimator.runtime.memory import NOTHING, swept_sine
from damper_estimator.signals.layout import COMMAND

_SECONDS = 1.0
_LEVELS = 5


def influence(model: DamperModel, low: float, high: float) -> float:
    """Largest change of the force in N that commands from ``low`` to ``high`` make.

    Tested on a sine of 20 mm that is swept from 0.5 to 6 Hz, temperature and pressure unknown. Each command is constant
    throughout, so that lags settle.
    """
    block = swept_sine(_SECONDS)
    forces = []
    for command in np.linspace(low, high, _LEVELS):
        block[COMMAND] = command
        forces.append(model.force(block))
    change = np.ptp(np.array(forces), axis=0)
    return float(np.max(change[np.isfinite(change)], initial=0.0))


def checked_limits(model: DamperModel, limits: tuple[float, float] | None) -> tuple[float, float]:
    """The commands between which the model can be inverted; None for those of its fit.

    Raises:
        InputError: if there are none, they are not in order, the model's force does not depend on the command
            between them, or it has effects of the measurement chain.
    """
    if model.channel_effects:
        raise InputError(
            f"model {model.name}: {', '.join(model.channel_effects)} belong to the measurement chain; correct "
            "the signal map and remove them from the model"
        )
    low, high = _fitted_commands(model) if limits is None else limits
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise InputError(
            f"model {model.name}: limits of the command {low:g} to {high:g} are not a range; give the lowest and the "
            "highest that the driver can set"
        )
    if not influence(model, low, high) > NOTHING * _largest(model, low):
        raise InputError(
            f"model {model.name}: its force does not depend on the command between {low:g} and {high:g}, so no command "
            "gives a desired force; fit a model with a command (damper-estimator models) to recordings that have one"
        )
    return float(low), float(high)


def _fitted_commands(model: DamperModel) -> tuple[float, float]:
    region = model.fit.get("region") or {}
    if "command" not in region:
        raise InputError(
            f"model {model.name}: was not fitted on recordings with a command; give the lowest and the highest command "
            "that may be sent"
        )
    low, high = region["command"]
    return float(low), float(high)


def _largest(model: DamperModel, command: float) -> float:
    block = swept_sine(_SECONDS)
    block[COMMAND] = command
    return float(np.max(np.nan_to_num(np.abs(model.force(block))), initial=1.0))
