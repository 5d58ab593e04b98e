"""Hydraulic force of a piston with a leak, a preloaded blow-off valve and a port in series, per direction.

    F_leak = K_leak nu^0.25 |v|^1.75          (3)
    F_port = K_port nu^0.25 |v|^1.75          (4)
    F_blow = F_preload + K_spring |v|         (5)
    F = sign(v) [ F_leak F_blow / (F_leak^Ktr + F_blow^Ktr)^(1/Ktr) + F_port ]      (2)

v in m/s, nu in mm^2/s, forces in N, K_leak and K_port in kg/(mm^0.5 m^0.75), K_spring in N s/m, Ktr without
unit. Leak and blow-off share one pressure: one effect. Below 7 mm/s the blow-off force is set very large, so that only
the leak acts. No state. Source: Carrera Akutain et al., eqs. (2) to (5), Table 1.
"""

from damper_estimator.compiled import compiled
from damper_estimator.effects.contract import Effect, Parameter, Setting
from damper_estimator.signals.layout import V

EXPONENT = 1.75  # turbulent flow, Reybrouck 1994


@compiled
def kernel(parameters, settings, kinematics, state, force):
    """F += eq. (2); five parameters of rebound, then five of compression."""
    viscosity = settings[0] ** 0.25
    for i in range(force.size):
        v = kinematics[V, i]
        speed = abs(v)
        k = 0 if v > 0.0 else 5
        flow = viscosity * speed**EXPONENT
        leak = parameters[k] * flow
        hydraulic = leak
        if speed > settings[1] and leak > 0.0:
            blow_off = parameters[k + 1] + parameters[k + 2] * speed
            if blow_off <= 0.0:
                hydraulic = 0.0
            else:
                # The smaller of the two is factored out of the power, so that it cannot overflow.
                small, large = min(leak, blow_off), max(leak, blow_off)
                transition = parameters[k + 3]
                hydraulic = small * (1.0 + (small / large) ** transition) ** (-1.0 / transition)
        total = hydraulic + parameters[k + 4] * flow
        force[i] += total if v > 0.0 else -total


def _direction(name: str, leak: float, preload: float, spring: float) -> tuple[Parameter, ...]:
    restriction = "kg/(mm^0.5 m^0.75)"
    return (
        Parameter(f"leak_{name}", restriction, leak, 0.0, 1e6, f"leak restriction in {name}"),
        Parameter(f"preload_{name}", "N", preload, 0.0, 20000.0, f"preload of the blow-off valve in {name}"),
        Parameter(f"spring_{name}", "N s/m", spring, 0.0, 50000.0, f"stiffness of the blow-off valve in {name}"),
        Parameter(f"transition_{name}", "1", 3.0, 0.5, 20.0, f"sharpness of the opening in {name}"),
        Parameter(f"port_{name}", restriction, 100.0, 0.0, 1e5, f"port restriction in {name}"),
    )


EFFECT = Effect(
    kernel=kernel,
    kind="source",
    phenomenon="blow_off",
    tests=("blow-off",),
    parameters=_direction("rebound", 15000.0, 400.0, 800.0) + _direction("compression", 10000.0, 250.0, 500.0),
    settings=(
        Setting("viscosity", "mm^2/s", 15.0, "kinematic viscosity of the oil", lower=0.1),
        Setting("switch", "m/s", 0.007, "below this speed the blow-off valve is shut", lower=0.0),
    ),
    shows="a knee in F-v: progressive below, much flatter above the opening speed",
    separate="speeds well above and below the knee in both directions",
    trial=None,
)
