"""The models of the soak's dampers, identified by ``fit`` on recordings of the same plant; saved in out/.

One model for the front dampers, whose oil warms up, and one for the rear ones. The recordings' currents step at random,
cold and hot, so that the region of the fit covers the campaign.
"""

import hashlib
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import soak_plant
import yaml
from soak_plant import AMBIENT, HOTTEST, LIMITS, NAMES, STEP, TEMPERATURE, WARMING, Corner, Driver, Sensors, damper

from damper_estimator.identification import error_bound, fit, fit_record
from damper_estimator.model import load_model, save_model
from damper_estimator.recordings import BagWriter, Stream, floats, joint_states, open_bag, temperatures
from damper_estimator.signals import Measurement, SignalMap, measure

RATE = 500  # Hz
SECONDS = 25.0
ROUGHNESS = 1.4  # of the recorded road, so that the campaign's road seldom leaves the region of the fit
START = 1_700_000_000_000_000_000
KNOTS = (-1.0, -0.5, -0.25, -0.12, -0.06, -0.03, -0.01, 0.0, 0.01, 0.03, 0.06, 0.12, 0.25, 0.5, 1.0)  # m/s


def models(folder: Path) -> Path:
    """The folder with one model per damper, and the signal maps ``plain.yaml`` and ``fused.yaml`` next to it."""
    sources = b"".join(
        Path(module.__file__).read_bytes() for module in (sys.modules[__name__], soak_plant, fit_record, error_bound)
    )
    target = folder / hashlib.sha256(sources).hexdigest()[:12]
    if not target.exists():
        folder.mkdir(parents=True, exist_ok=True)
        unfinished = Path(tempfile.mkdtemp(dir=folder))
        (unfinished / "models").mkdir()
        for warms in (True, False):
            found = _fitted(unfinished, warms)
            for name in (name for name, own_warms in zip(NAMES, WARMING, strict=True) if own_warms == warms):
                save_model(found.model, unfinished / "models" / f"{name}.yaml")
        _write_maps(unfinished)
        try:
            unfinished.rename(target)
        except OSError:  # another soak run was faster
            shutil.rmtree(unfinished)
    return target


def _fitted(folder: Path, warms: bool):
    low, high = (AMBIENT[0], AMBIENT[1] + HOTTEST) if warms else (AMBIENT[2], AMBIENT[2])
    start = folder / "start.yaml"
    start.write_text(yaml.safe_dump(_start(warms, 0.5 * (low + high))))
    measured = [_measured(folder / f"{warms}_{number}.mcap", number, warms, degrees)
                for number, degrees in enumerate((low - 3.0, 0.5 * (low + high), high + 3.0))]  # fmt: skip
    return fit(load_model(str(start)), measured, seed=1)


def _start(warms: bool, reference: float) -> dict[str, object]:
    fade = [{"temperature_gain": {"reference": reference, "fade": 0.004, "gas": 1.0}}] if warms else []
    effects = [
        {"smooth_curve": {"velocity": list(KNOTS), "force": [1200.0 * v / (abs(v) + 0.2) for v in KNOTS]}},
        *fade,
        {"quadratic_gas": {"square": 0.0, "slope": 250.0, "constant": 0.0}},
        {"command_yield": {"force": 500.0, "saturation": 5.0, "way": 8e-4, "time_constant": 0.018}},
        {"command_yield": {"force": 500.0, "saturation": 5.0, "way": 3e-3, "time_constant": 0.018}},
        {"force_lag": {"time_constant": 0.001}},
    ]
    return {"name": "soak", "source": "the soak", "effects": effects, "fixed": ["quadratic_gas.constant"]}


def _measured(path: Path, seed: int, warms: bool, degrees: float) -> Measurement:
    """A recording like a logger's, read back; the oil is ``degrees`` warm throughout."""
    random, sensors, driver = np.random.default_rng([seed, 5]), Sensors(), Driver()
    corner = Corner(100 + seed, damper(False, degrees, degrees), ROUGHNESS)
    count, until, wanted = round(SECONDS * RATE), 0, 0.0
    table = np.empty((count, 4))
    for i in range(count):
        if i >= until:
            until = i + int(random.uniform(0.01, 0.6) * RATE)
            wanted = random.uniform(*LIMITS) if random.random() < 0.7 else random.choice(LIMITS)
        driver.take(wanted, i / RATE)
        sample = corner.drive(round(1.0 / RATE / STEP), driver.step(i / RATE, 1.0 / RATE))
        travel = sensors.displacement_of(sample.travel, random)
        current = sample.current + sensors.current * random.standard_normal()
        table[i] = travel, sample.force, current, sample.temperature
    table[:, 1] += sensors.gauge * random.standard_normal(count)
    stamp = START + np.round(np.arange(count) * 1e9 / RATE).astype(np.int64)
    tenth = slice(None, None, RATE // 10)
    with BagWriter(path) as bag:
        bag.write_streams([
            Stream("/suspension/one/current", "std_msgs/msg/Float64", stamp - 1000, floats(table[:, 2])),
            Stream("/suspension/displacement", "sensor_msgs/msg/JointState", stamp,
                   joint_states(["one"], stamp, position=table[:, :1])),
            Stream("/suspension/force", "sensor_msgs/msg/JointState", stamp,
                   joint_states(["one"], stamp, effort=table[:, 1:2])),
            Stream("/suspension/one/temperature", "sensor_msgs/msg/Temperature", stamp[tenth],
                   temperatures(stamp[tenth], table[tenth, 3])),
        ])  # fmt: skip
    with open_bag(path) as bag:
        return measure(bag, SignalMap(), "one")


def _write_maps(folder: Path) -> None:
    """Limits and ages of the channels; fusion uses the accelerometers."""
    *limits, age = TEMPERATURE
    dampers = {
        name: {
            "command": {"topic": f"/suspension/{name}/current", "limits": list(LIMITS)},
            "temperature": {"topic": f"/suspension/{name}/temperature", "limits": list(limits), "max_age": age},
        }
        for name in NAMES
    }
    (folder / "plain.yaml").write_text(yaml.safe_dump({"dampers": dampers}))
    (folder / "fused.yaml").write_text(yaml.safe_dump({"filter": {"fusion": {}}, "dampers": dampers}))


if __name__ == "__main__":
    print(models(Path("out/soak")))
