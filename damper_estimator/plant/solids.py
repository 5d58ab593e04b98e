"""Forces of solid parts: elasto-plastic elements, seals, rubber stops, rubber mount (compiled)."""

from damper_estimator.compiled import compiled
from damper_estimator.plant.parts import AMBIENT_PRESSURE

ELEMENTS = 5
"""Elasto-plastic elements in a stack."""


@compiled
def element_reach(reach, number):
    """Travel in m after which one element of a stack slips: evenly distributed from 0.2 to 1.8 times the mean."""
    return reach * (0.2 + 1.6 * number / (ELEMENTS - 1))


@compiled
def stack_share(position, sliders, first, reach):
    """Force of a stack of parallel spring-slider elements as a share (-1 to 1) of its strength (Iwan, 1966).

    ``sliders[first + i]`` is the position of slider i (m), ``position`` that of the free end. Rate-independent: the
    share is a function of the position and of the sliders at the last committed step.
    """
    share = 0.0
    for number in range(ELEMENTS):
        stretch = (position - sliders[first + number]) / element_reach(reach, number)
        share += min(1.0, max(-1.0, stretch))
    return share / ELEMENTS


@compiled
def drag_sliders(position, sliders, first, reach):
    """Completes a step: sliders of slipped elements follow."""
    for number in range(ELEMENTS):
        travel = element_reach(reach, number)
        slider = sliders[first + number]
        sliders[first + number] = min(position + travel, max(position - travel, slider))


@compiled
def seal_strength(seal, rebound_pressure, velocity):
    """Sliding force of the seals in N: grows with the pressure on them, falls from stiction."""
    pressed = seal.force + seal.per_pressure * max(rebound_pressure - AMBIENT_PRESSURE, 0.0)
    speed = velocity / seal.stribeck_velocity
    return pressed * (1.0 + seal.stiction / (1.0 + speed * speed))


@compiled
def stop_force(stops, displacement, velocity):
    """Force in N (positive resists extension) of the rubber stops; they only push."""
    bump, end = stops.compression - displacement, displacement - stops.rebound
    if bump > 0.0:
        stretch = bump / stops.progression
        return -stops.stiffness * bump * (1.0 + stretch * stretch) * max(1.0 - stops.loss * velocity, 0.0)
    if end > 0.0:
        stretch = end / stops.progression
        return stops.stiffness * end * (1.0 + stretch * stretch) * max(1.0 + stops.loss * velocity, 0.0)
    return 0.0


@compiled
def mount_force(mount, deflection, rate):
    """Force in N of the rubber mount: k d (1 + (d/progression)^2) + c d'."""
    stretch = deflection / mount.progression
    return mount.stiffness * deflection * (1.0 + stretch * stretch) + mount.damping * rate
