"""Prints how long fits take: the Carrera-Akutain model and baselines on two recordings of 30722 samples.

    python benchmarks/fit_speed.py

The recordings are made with the model itself (random displacement of 5 and 10 mm rms, 0.1 to 20 Hz, 1.95 ms steps,
1 % force noise), so the printed deviation from the truth, in standard errors, says whether the fit arrived. The
first fit warms the compile cache up.
"""

from time import perf_counter

import numpy as np

from damper_estimator.identification import fit
from damper_estimator.model import DamperModel, load_model
from damper_estimator.signals import Measurement, default_signals
from damper_estimator.signals.kinematics import differentiate_recording

SAMPLES, STEP = 30722, 1.95e-3
TRUTH = {
    "leak_blow_off_port.leak_rebound": 30000.0,
    "leak_blow_off_port.preload_rebound": 700.0,
    "leak_blow_off_port.transition_rebound": 2.0,
    "leak_blow_off_port.spring_compression": 900.0,
    "leak_blow_off_port.port_compression": 250.0,
    "seal_friction.rebound": 30.0,
    "acceleration_hysteresis.constant": -3.0,
    "static_force.force": 12.0,
}


def recording(model: DamperModel, rms: float, seed: int) -> Measurement:
    """A measurement of a damper that is the model."""
    random = np.random.default_rng(seed)
    frequency = np.fft.rfftfreq(SAMPLES, STEP)
    inside = (frequency > 0.1) & (frequency < 20.0)
    spectrum = np.where(inside, np.maximum(frequency, 0.3) ** -1.2, 0.0)
    x = np.fft.irfft(spectrum * np.exp(2j * np.pi * random.uniform(size=frequency.size)), SAMPLES)
    x *= rms / x.std()
    stamp = np.round(np.arange(SAMPLES) * STEP * 1e9).astype(np.int64)
    kinematics, counts = differentiate_recording(stamp, x, 60.0, 0.1)
    force = model.force(kinematics.block)
    force += 0.01 * force.std() * random.standard_normal(SAMPLES)
    name = f"{1000 * rms:.0f} mm rms"
    return Measurement(
        name, "damper", kinematics, force, kinematics.warm(), counts, force, x, 60.0, 30.0, default_signals("damper")
    )


def main() -> None:
    """Prints one line per model."""
    truth = load_model("carrera_akutain").with_values(TRUTH)
    measurements = [recording(truth, 0.005, 1), recording(truth, 0.010, 2)]
    fit(load_model("carrera_akutain"), measurements)
    print(f"2 x {SAMPLES} samples          identified   seconds  evaluations  esr       worst deviation")
    for name in ("carrera_akutain", "viscous_curve", "memoryless_baseline", "linear_viscous"):
        began = perf_counter()
        result = fit(load_model(name), measurements)
        seconds = perf_counter() - began
        true = {slot.address: slot.value for slot in truth.slots}
        off = [abs(p.value - true[p.name]) / p.standard_error for p in result.parameters if p.name in true]
        worst = f"{max(off):.1f} standard errors" if name == truth.name else "-"
        print(
            f"{name:<28} {len(result.parameters):>10} {seconds:>9.2f} {result.evaluations:>12}"
            f"  {result.esr:<8.2g}  {worst}"
        )


if __name__ == "__main__":
    main()
