"""Creates the cases of the hidden-effect bench: the user's recordings and model, and the true quantities.

Simulated by the plant, sampled by imperfect sensors, written as bags and read back. The user's model is a good one: the
structure that a careful engineer would choose for the damper without the hidden effect, identified on the base
recording.
"""

import os
import pickle
from dataclasses import asdict, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from hidden_plans import BENCHED, Plan
from scipy.interpolate import CubicSpline

from damper_estimator.identification import fit
from damper_estimator.model import DamperModel, parse_model
from damper_estimator.model.model_files import model_yaml
from damper_estimator.plant import (
    DAMPERS,
    PHENOMENA,
    Damper,
    Drive,
    Record,
    Sensors,
    Setup,
    record,
    simulate,
    strength,
    switched,
)
from damper_estimator.plant import measure as measure_record
from damper_estimator.plant.parts import AMBIENT_PRESSURE
from damper_estimator.recordings import open_bag
from damper_estimator.signals import Measurement, SignalMap, default_signals, measure
from damper_estimator.vehicle import drive
from damper_estimator.workflows import write_record

SPEEDS = (0.004, 0.01, 0.02, 0.035, 0.055, 0.08, 0.11, 0.15, 0.2, 0.27, 0.36, 0.5, 0.7, 1.0)
"""m/s, knots of the user's curve in both directions, within the range of the base recording."""

RECORDS = ("base", "fit", "unseen", "twin")


def made_by() -> str:
    """Fingerprint of the plant: its strength with every phenomenon at its ordinary magnitude."""
    digest = sha256()
    for number, (name, phenomenon) in enumerate(PHENOMENA.items()):
        setup = Setup(DAMPERS[BENCHED[number % len(BENCHED)]], Sensors())
        motion = drive("road" if number % 2 else "random10", setup.damper, 6.0, number)
        on = phenomenon.on(setup, 1.0)
        sensed = measure_record(simulate(on.damper, motion), on.sensors, number)
        digest.update(np.round(sensed.force.value).astype(int).tobytes())
        digest.update(f"{name} {strength(phenomenon.off(setup, 1.0), on, motion):.3g}".encode())
    return digest.hexdigest()[:12]


def make_case(plan: Plan, folder: Path) -> dict[str, Any]:
    """A case, from ``folder`` if it exists there.

    The keys: ``name``, ``kind``, ``phenomena``, ``damper``, ``excitation``, ``unseen_excitation``, ``calibrations``,
    ``strengths`` (on fit and unseen recording), ``base``, ``fit``, ``unseen`` and ``twin`` (the unseen recording
    without the hidden effect), all Measurements, ``bags``, ``signals`` (signal map), ``model`` (the user's),
    ``base_rmse`` (on the base recording), ``twin_rmse`` and ``floor`` in N, with the gauge's zero and linear drift
    removed.
    """
    place = folder / "cases" / f"{plan.name}.pkl"
    if place.exists():
        with place.open("rb") as stream:
            return pickle.load(stream)
    off, on = switched(plan.setup, plan.calibrations)
    base, fitted, unseen = plan.drives()
    bags = folder / "bags" / plan.name
    bags.mkdir(parents=True, exist_ok=True)
    chain = signal_map(plan)
    records, found = {}, {}

    def take(name: str, setup: Setup, motion: Drive, noise: int) -> None:
        records[name] = with_decoys(record(setup, motion, 10 * plan.seed + noise), plan)
        found[name] = measured(records[name], bags / f"{name}.mcap", chain, plan.with_current)

    take("base", off, base, 0)
    take("fit", on, fitted, 1)
    take("unseen", on, unseen, 2)
    if on == off:
        records["twin"], found["twin"] = records["unseen"], found["unseen"]
    else:
        take("twin", off, unseen, 2)  # with the noise of the unseen recording
    model = user_model(plan, off.damper, found["base"])
    if on.damper == off.damper:
        perfect = "twin"
    elif on.sensors == off.sensors:
        perfect = "unseen"
    else:
        perfect = "perfect"
        take(perfect, Setup(on.damper, off.sensors), unseen, 2)
    case = {
        "name": plan.name,
        "kind": plan.kind,
        "phenomena": plan.phenomena,
        "damper": plan.damper,
        "excitation": plan.fit,
        "unseen_excitation": plan.unseen,
        "wanted": plan.wanted,
        "calibrations": [asdict(item) for item in plan.calibrations],
        "strengths": (tuple(item.strength for item in plan.calibrations), plan.unseen_strength),
        **{name: found[name] for name in RECORDS},
        "bags": {name: found[name].recording for name in RECORDS},
        "signals": chain,
        "model": model,
        "base_rmse": error(model, found["base"]),
        "twin_rmse": error(model, found["twin"]),
        "floor": floor(records[perfect], found[perfect]),
        "force_rms": float(without_zero(_judged_force(found["unseen"])).std()),
    }
    place.parent.mkdir(parents=True, exist_ok=True)
    partial = place.with_suffix(f".{os.getpid()}.part")
    with partial.open("wb") as stream:
        _Pickler(stream).dump(case)
    partial.rename(place)
    return case


class _Pickler(pickle.Pickler):
    """Saves models as the text of their files: compiled programs cannot be saved, and effects change."""

    def reducer_override(self, one: object) -> Any:
        if isinstance(one, DamperModel):
            return parse_model, (yaml.safe_load(model_yaml(one)), one.name)
        return NotImplemented


def signal_map(plan: Plan) -> SignalMap:
    """The user's map: default topics, and the stated spring if the gauge carries one."""
    sensors = plan.setup.sensors
    signals = replace(default_signals(plan.damper), spring_rate=sensors.spring_rate, preload=sensors.preload)
    return SignalMap(dampers={plan.damper: signals})


def with_decoys(one: Record, plan: Plan) -> Record:
    """The record with a rising temperature next to the damper, if that of the oil is constant."""
    if "temperature_fade" in plan.phenomena or plan.seed % 2 == 0:
        return one
    warm = one.sensed.temperature
    seconds = warm.stamp / 1e9
    rng = np.random.default_rng([plan.seed, int(1e6 * abs(one.truth.drive.displacement).max())])
    rise = rng.uniform(4.0, 12.0) * (1.0 - np.exp(-seconds / rng.uniform(15.0, 60.0)))
    decoy = replace(warm, value=np.round(warm.value - 15.0 + rise, 2))
    return replace(one, sensed=replace(one.sensed, temperature=decoy))


def measured(one: Record, bag: Path, chain: SignalMap, with_current: bool) -> Measurement:
    """The record as a bag, read back as a measurement."""
    name = one.setup.damper.name
    write_record(bag, {name: one}, with_current)
    with open_bag(bag) as opened:
        return measure(opened, chain, name)


def user_model(plan: Plan, damper: Damper, base: Measurement) -> DamperModel:
    """The model of an honest user: identified on the base recording, without the hidden effect.

    A force-velocity curve, the gas force with its charge from the data sheet, pre-sliding friction, and a lag of a few
    tenths of a millisecond for the oil's compliance (its first-order form: a series spring would take 200 times as long
    and is no better here). If the valves' lag is hidden, the compliance is the track paper's constant times
    acceleration instead; if the oil's compliance is hidden, the model has none.
    """
    rod = np.pi / 4.0 * damper.geometry.rod**2
    charge = round((damper.gas.pressure - AMBIENT_PRESSURE) * rod, 1)
    knots = curve_knots(base)
    effects: list[dict[str, Any]] = [{"viscous_curve": {"velocity": knots, "force": [0.0] * len(knots)}}]
    fixed = []
    if "gas_spring" in plan.phenomena:
        effects.append({"static_force": {"force": -charge}})
        fixed.append("static_force.force")
    else:
        volume = np.pi / 4.0 * damper.geometry.bore**2 * damper.gas.length
        effects.append({"gas_spring": {"static_force": charge, "volume": volume, "rod_area": rod}})
        fixed.append("gas_spring.static_force")
    if "friction" not in plan.phenomena:
        effects.append({"dahl": {"force": 2.0 * damper.seal.force, "stiffness": 2e5, "exponent": 1.0}})
    if "valve_delay" in plan.phenomena:
        effects.append({"acceleration_hysteresis": {}})
    elif "oil_compressibility" not in plan.phenomena:
        effects.append({"force_lag": {"time_constant": 3e-4}})
    content = {"name": plan.damper, "source": "the user's", "effects": effects, "fixed": fixed}
    return fit(parse_model(content, plan.damper), [base], starts=0).model


def curve_knots(base: Measurement) -> list[float]:
    """Knots of a curve over the speeds of a recording, in m/s."""
    low, high = np.quantile(base.kinematics.velocity[base.judged], [0.0005, 0.9995])
    below = [speed for speed in SPEEDS if speed < -0.85 * low]
    above = [speed for speed in SPEEDS if speed < 0.85 * high]
    return [round(float(v), 6) for v in (low, *(-s for s in reversed(below)), 0.0, *above, high)]


def residual(model: DamperModel, measurement: Measurement) -> np.ndarray:
    """(k,) modelled less measured force in band, N, over the judged samples, as `compare` judges it."""
    modelled = model.force(measurement.kinematics.block)
    return (measurement.in_band(modelled) - measurement.in_band(measurement.force))[measurement.judged]


def _judged_force(measurement: Measurement) -> np.ndarray:
    return measurement.in_band(measurement.force)[measurement.judged]


def without_zero(values: np.ndarray) -> np.ndarray:
    """(k,) values less the straight line through them: the gauge's zero and its drift."""
    time = np.linspace(-1.0, 1.0, values.size)
    return values - values.mean() - time * (values @ time) / (time @ time)


def error(model: DamperModel, measurement: Measurement, zero_free: bool = True) -> float:
    """RMS of the residual in N; with the gauge's zero and drift removed, or as `compare` prints it."""
    left = residual(model, measurement)
    return float(np.sqrt(np.mean((without_zero(left) if zero_free else left) ** 2)))


def floor(one: Record, measurement: Measurement) -> float:
    """RMS error in N of a perfect model with the user's filter.

    The perfect model is the plant itself, driven by the measured displacement behind the filter, compared with the
    measured force in band; the force must come from a chain without errors.
    """
    motion, kinematics = one.truth.drive, measurement.kinematics
    moment = kinematics.time + one.sensed.displacement.stamp.min() / 1e9
    inside = np.clip(motion.time, moment[0], moment[-1])
    stroke = one.setup.damper.geometry
    travel = np.clip(
        CubicSpline(moment, kinematics.displacement)(inside), -stroke.compression_stroke, stroke.rebound_stroke
    )
    again = simulate(one.setup.damper, Drive(motion.name, motion.step, travel, motion.current, motion.seed))
    force = np.interp(moment, again.time, again.force)
    left = (measurement.in_band(force) - measurement.in_band(measurement.force))[measurement.judged]
    return float(np.sqrt(np.mean(without_zero(left) ** 2)))
