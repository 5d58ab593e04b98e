"""Proposes a signal map for a recording from topics, types, field names and ranges, and reports its guesses."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings import Bag
from damper_estimator.signals import (
    Channel,
    DamperSignals,
    SignalMap,
    default_signals,
    measure,
    named_element,
    usual_range,
)
from damper_estimator.validation import excitation

WORDS = {
    "force": re.compile(r"force|effort|gauge|gage|strain|load|wrench|(?:^|[/_.])f(?:$|[/_.\[])", re.I),
    "temperature": re.compile(r"temp", re.I),
    "pressure": re.compile(r"press", re.I),
    "command": re.compile(r"current|command|cmd|valve|volt|ampere|(?:^|[/_.])i(?:$|[/_.\[])", re.I),
    "acceleration": re.compile(r"acc", re.I),
    "displacement": re.compile(
        r"disp|travel|stroke|position|pot\b|length|height|lvdt|range|deflection|(?:^|[/_.])x(?:$|[/_.\[])", re.I
    ),
}
_ROLE_OF_TYPE = {"sensor_msgs/msg/Temperature": "temperature", "sensor_msgs/msg/FluidPressure": "pressure"}
_OURS = re.compile(r"^/damper_estimator/")
_EXAMINED = 200  # messages of each topic


@dataclass(frozen=True)
class Candidate:
    """A number in a recording that could be a channel."""

    role: str
    topic: str
    field: str
    damper: str


@dataclass(frozen=True)
class Proposal:
    """A signal map and the guesses behind it.

    Attributes:
        signal_map: without dampers if nothing was recognised.
        guesses: one sentence each.
    """

    signal_map: SignalMap
    guesses: tuple[str, ...]


def propose(bag: Bag) -> Proposal:
    """Proposes a signal map for the recording."""
    candidates = list(_candidates(bag))
    guesses: list[str] = []
    dampers: dict[str, DamperSignals] = {}
    moved = [c for c in candidates if c.role == "displacement"]
    for c in moved:
        name = c.damper or ("damper" if len(moved) == 1 else _last_word(c.topic))
        signals = replace(default_signals(name), displacement=Channel(c.topic, c.field, given=True))
        for role in ("force", "command", "temperature", "pressure"):
            match = _partner(c, [o for o in candidates if o.role == role], len(moved))
            if match is not None:
                channel = Channel(match.topic, match.field, unit="A" if role == "command" else "", given=True)
                signals = signals.with_channel(role, channel)
        dampers[name] = _scaled(bag, name, signals, guesses)
    return Proposal(SignalMap(dampers=dampers, where="proposed map"), tuple(guesses))


def _candidates(bag: Bag) -> Iterator[Candidate]:
    for topic in bag.topics:
        if _OURS.match(topic.name) or not topic.messages:
            continue
        try:
            batch = next(iter(bag.batches([topic.name], size=_EXAMINED)))
            messages = [message for _, message in batch.messages(topic.name)]
        except InputError:
            continue  # a type that cannot be decoded has no channels
        seen: dict[Candidate, None] = {}
        for message in messages[:20]:
            seen |= dict.fromkeys(_of_message(topic.name, topic.type, message))
        yield from seen


def _of_message(topic: str, type_name: str, message: Any) -> Iterator[Candidate]:
    if type_name == "sensor_msgs/msg/JointState":
        for field, role in (("position", "displacement"), ("effort", "force")):
            for name in list(message.name)[: len(getattr(message, field))]:
                yield Candidate(role, topic, named_element(field, str(name)), str(name))
        return
    for field in _numbers(message, 3):
        text = f"{topic}.{field}"
        typed = _ROLE_OF_TYPE.get(type_name)
        if typed is not None and field == "variance":
            continue
        guessed = typed or next((role for role, words in WORDS.items() if words.search(text)), None)
        if guessed is not None:
            yield Candidate(guessed, topic, field, "")


def _numbers(message: object, depth: int) -> Iterator[str]:
    """Paths of the scalar numbers in a message, headers left out."""
    for name, value in vars(message).items():
        if name in ("header", "__msgtype__") or depth == 0:
            continue
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield name
        elif hasattr(value, "__msgtype__"):
            yield from (f"{name}.{inner}" for inner in _numbers(value, depth - 1))


def _last_word(topic: str) -> str:
    return topic.strip("/").replace("/", "_")


def _tokens(text: str) -> set[str]:
    return set(re.split(r"[^a-z0-9]+", text.lower())) - {""}


def _partner(displacement: Candidate, others: list[Candidate], dampers: int) -> Candidate | None:
    """The candidate of the same damper: by name, or the only one for a single damper, or by the most similar topic."""
    named = [
        o
        for o in others
        if displacement.damper and (o.damper == displacement.damper or displacement.damper.lower() in o.topic.lower())
    ]
    if named:
        return named[0]
    nameless = [o for o in others if not o.damper or not displacement.damper]
    if dampers == 1:
        return nameless[0] if nameless else (others[0] if len(others) == 1 else None)
    if displacement.damper or not nameless:
        return None
    shared = [len(_tokens(o.topic) & _tokens(displacement.topic)) for o in nameless]
    return nameless[int(np.argmax(shared))]


def _scaled(bag: Bag, name: str, signals: DamperSignals, guesses: list[str]) -> DamperSignals:
    """Units from the ranges, sign from the slope of the force over velocity."""
    where = signals.displacement
    raw = bag.columns(where.topic, [where.field]).values[:, 0]
    span = usual_range(raw[np.isfinite(raw)])
    guesses.append(
        f"{name}: displacement is {where.field} on {where.topic}, {'in mm' if span > 1.0 else 'in m'} (it "
        f"spans {span:.4g})"
    )
    if span > 1.0:
        signals = replace(signals, displacement=replace(where, scale=1e-3))
    for role in ("force", "command", "temperature", "pressure"):
        channel = getattr(signals, role)
        if channel.given:
            guesses.append(f"{name}: {role} is {channel.field} on {channel.topic}")
    if signals.force.given:
        signals = _force_scaled(bag, name, signals, guesses)
    return signals


def _force_scaled(bag: Bag, name: str, signals: DamperSignals, guesses: list[str]) -> DamperSignals:
    raw = bag.columns(signals.force.topic, [signals.force.field]).values[:, 0]
    span = usual_range(raw[np.isfinite(raw)])
    if 0.0 < span < 20.0:
        signals = replace(signals, force=replace(signals.force, scale=1e3))
        guesses.append(f"{name}: the force spans {span:.3g}, so kN is assumed; if it is V, state the gauge's scale")
    try:
        moved = excitation(measure(bag, SignalMap(dampers={name: signals}), name))
    except InputError:
        return signals
    if moved.damping < 0.0:
        inverted = replace(signals.displacement, scale=-signals.displacement.scale)
        signals = replace(signals, displacement=inverted)
        guesses.append(
            f"{name}: force falls with velocity, so displacement is assumed positive in compression and "
            "inverted; if the gauge has the wrong sign, invert that instead"
        )
    if abs(moved.stiffness) > 10_000.0:
        guesses.append(
            f"{name}: force rises by {moved.stiffness / 1e3:.3g} N/mm over displacement: if a spring is "
            "parallel to the damper, state spring_rate and preload"
        )
    return signals
