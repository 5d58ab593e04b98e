"""The parameters of the example controller, each declared once (`parameter`). Independent of ROS."""

from dataclasses import dataclass

from damper_estimator.control import LAWS, LEAD
from damper_estimator.node.parameter import STARTING, Declaration, declarations_of, parameter


@dataclass(frozen=True)
class ControllerSettings:
    """The controller's settings; times in s, forces in N."""

    law: str = parameter(
        "mixed",
        "control law of the desired force",
        "'skyhook', 'groundhook', 'mixed' or 'passive'; docs/control.md describes them.",
        changes=STARTING,
        allowed=(*LAWS, "mixed"),
    )
    damping: float = parameter(
        2500.0, "N s/m, of the law", "N s/m, damping of the law.", changes=STARTING, low=0.0, high=1e5
    )
    share: float = parameter(
        0.7,
        "of the skyhook in the mixed law, 0.0 to 1.0",
        "Share of the skyhook in the mixed law, 0.0 (groundhook) to 1.0 (skyhook).",
        changes=STARTING,
        low=0.0,
        high=1.0,
    )
    rest_force: float = parameter(
        0.0,
        "N, of the dampers at rest, added to the law's force",
        "N, force of the dampers at rest (gas), added to the law's force.",
        changes=STARTING,
        low=-1e5,
        high=1e5,
    )
    lead: float = parameter(
        LEAD,
        "s after an estimate for which the force is desired; that of the estimator's lead",
        "s after an estimate for which the force is desired, with constant accelerations. The same as the estimator's "
        "lead; with a table, its velocity is predicted too. 0.0 predicts nothing.",
        changes=STARTING,
        low=0.0,
        high=1.0,
    )
    extrapolating_limit: float = parameter(
        500.0,
        "N, largest desired force in addition to rest_force while the estimate is EXTRAPOLATING",
        "N, largest desired force in addition to rest_force, in both directions, while the estimate is EXTRAPOLATING: "
        "its trend is right, its amount is not proven. 0.0 requests only the force at rest.",
        changes=STARTING,
        low=0.0,
        high=1e5,
    )
    table: str = parameter(
        "",
        "force_velocity.csv of damper-estimator export; '' uses the estimator's inverse",
        "force_velocity.csv of `damper-estimator export`: currents by look-up. '' requests forces from the estimator, "
        "which answers with currents by the inverse of its model.",
        changes=STARTING,
    )
    safe_current: float = parameter(
        0.0,
        "A, with a table: commanded without a usable estimate",
        "A, with a table: commanded without a usable estimate, and at the end. The estimator has its own safe_current; "
        "set both.",
        changes=STARTING,
        low=-1e3,
        high=1e3,
    )
    timeout: float = parameter(
        0.1,
        "s after which estimate, acceleration and added force are too old",
        "s after which an estimate, an acceleration and an added force are too old. Set it to a few sample times of "
        "your input.",
        changes=STARTING,
        low=0.002,
        high=10.0,
    )


DECLARATIONS: dict[str, Declaration] = declarations_of(ControllerSettings)
