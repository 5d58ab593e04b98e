"""The error of the step: its order and size, and the same numbers without the compiler."""

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from damper_estimator.plant import DAMPERS, PHENOMENA, STEP, Damper, Drive, Sensors, Setup, simulate

PASSENGER = DAMPERS["passenger_front"]
NOISE = Sensors().force_noise


def tones(step: float, seconds: float = 0.6) -> Drive:
    time = step * np.arange(round(seconds / step))
    rise = np.clip(time / 0.3, 0.0, 1.0)
    rise = rise**3 * (10.0 - 15.0 * rise + 6.0 * rise**2)
    motion = rise * (0.012 * np.sin(2.0 * np.pi * 3.1 * time) + 0.004 * np.sin(2.0 * np.pi * 11.3 * time))
    return Drive("tones", step, motion, np.ones_like(motion))


def switched_on(name: str, magnitude: float, damper: Damper = PASSENGER) -> Damper:
    return PHENOMENA[name].on(Setup(damper, Sensors()), magnitude).damper


CASES = {
    "passenger_front": PASSENGER,
    "rally_rear": DAMPERS["rally_rear"],
    "semi_active": DAMPERS["semi_active"],
    "aerated oil": switched_on("oil_compressibility", 8.0),
    "soft mount": switched_on("mount_compliance", 2.0),
    "slow shims": switched_on("valve_delay", 4.0),
    "slow shims on a mount": switched_on("valve_delay", 4.0, switched_on("mount_compliance", 2.0)),
    "cavitating": switched_on("cavitation", 6.0),
    "gelled": switched_on("hysteresis", 2.0),
    "heating": switched_on("temperature_fade", 20.0),
}


@pytest.mark.parametrize("damper", CASES.values(), ids=CASES)
def test_the_error_falls_with_the_square_of_the_step(damper: Damper) -> None:
    finest = simulate(damper, tones(STEP / 16)).force
    errors = [
        np.sqrt(np.mean((simulate(damper, tones(STEP / refined)).force - finest[:: 16 // refined]) ** 2))
        for refined in (1, 2, 4)
    ]
    order = -np.polyfit(range(3), np.log2(errors), 1)[0]
    assert 1.7 < order < 3.5
    assert errors[0] < 0.1 * NOISE


def test_stiff_oil_sets_no_limit_to_the_step() -> None:
    stiff = PASSENGER.with_part("oil", bulk_modulus=1e11, free_gas=1e-5)
    coarse, fine = simulate(stiff, tones(4 * STEP)).force, simulate(stiff, tones(STEP)).force
    assert np.isfinite(coarse).all()
    assert np.sqrt(np.mean((coarse - fine[::4]) ** 2)) < 0.02 * np.std(fine)


def test_without_the_compiler_the_numbers_are_the_same(tmp_path: Path) -> None:
    damper = replace(switched_on("mount_compliance", 2.0), name="plain")
    short = tones(STEP, 0.1)
    target = tmp_path / "force.npy"
    folders = [str(Path(__file__).parent), str(Path(__file__).resolve().parents[2])]
    program = (
        f"import sys, numpy; sys.path[:0] = {folders!r}; import test_plant_convergence as t\n"
        f"numpy.save({str(target)!r}, t.simulate(t.switched_on('mount_compliance', 2.0), t.tones(t.STEP, 0.1)).force)\n"
    )
    subprocess.run([sys.executable, "-c", program], check=True, env=os.environ | {"NUMBA_DISABLE_JIT": "1"})
    assert np.load(target) == pytest.approx(simulate(damper, short).force, rel=1e-9, abs=1e-7)
