"""The parameters of the example controller, for its node and for its launch file."""

from damper_estimator.control import LAWS
from damper_estimator.node.settings import STARTING, Declaration

DECLARATIONS: dict[str, Declaration] = {
    "law": Declaration("mixed", "which force is desired", STARTING, allowed=(*LAWS, "mixed")),
    "damping": Declaration(2500.0, "N s/m, of the law", STARTING, 0.0, 1e5),
    "share": Declaration(0.7, "of the skyhook in the mixed law, 0.0 to 1.0", STARTING, 0.0, 1.0),
    "rest_force": Declaration(0.0, "N, of the dampers at rest, added to what the law gives", STARTING, -1e5, 1e5),
    "extrapolating_limit": Declaration(
        500.0, "N, most that is desired on top of rest_force while the estimate is EXTRAPOLATING", STARTING, 0.0, 1e5
    ),
    "table": Declaration("", "force_velocity.csv of damper-estimator export; '' leaves it to the inverse", STARTING),
    "safe_current": Declaration(0.0, "A, by table: where there is nothing to act on", STARTING, -1e3, 1e3),
    "timeout": Declaration(
        0.1, "s after which estimate, acceleration and added force are too old", STARTING, 0.002, 10.0
    ),
}
