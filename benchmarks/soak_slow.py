"""Messages of the campaign besides the displacement: slow channels, the gauge, desired forces."""

from collections.abc import Sequence

import numpy as np
from soak_faults import Fault
from soak_judge import Judge
from soak_node import DESIRED_FORCE, FORCE, SoakedNode
from soak_plant import NAMES, Driver, Sample, Sensors
from soak_wire import joint_state, number, stamped

TEMPERATURE_EVERY, FORCE_EVERY = 25, 5  # samples


class Slow:
    """The senders of the slow channels; final.

    Attributes:
        active: the running faults, shared with the campaign.
    """

    def __init__(self, node: SoakedNode, judge: Judge, active: list[Fault], sensors: Sensors,
                 noise: np.random.Generator) -> None:  # fmt: skip
        self._node, self._judge, self.active, self._sensors, self._noise = node, judge, active, sensors, noise

    def send(self, index: int, now: float, stamp: int, drivers: Sequence[Driver], samples: Sequence[Sample],
             current: Sequence[float], felt: Sequence[float] | None, force: np.ndarray) -> None:  # fmt: skip
        """Sends all messages due before one sample; ``felt`` only if the accelerometers are used."""
        noise = self._noise
        for k, name in enumerate(NAMES):
            topic = f"/suspension/{name}"
            for value in self._altered("current", k, current[k], now) if drivers[k].is_on else ():
                self._node.publish(f"{topic}/current", number(value))
            for value in () if felt is None else self._altered("acceleration", k, felt[k], now):
                self._node.publish(f"{topic}/acceleration", stamped(stamp, 0.0, 0.0, value, 0.0, 0.0, 0.0))
            if index % TEMPERATURE_EVERY == 0:
                warm = samples[k].temperature + self._sensors.temperature * noise.standard_normal()
                for value in self._altered("temperature", k, warm, now):
                    self._node.publish(f"{topic}/temperature", stamped(stamp, value, 0.0))
                for value in self._altered("pressure", k, samples[k].pressure, now):
                    self._node.publish(f"{topic}/pressure", stamped(stamp, value, 0.0))
        if index % FORCE_EVERY == 0:
            gauge = force + self._sensors.gauge * noise.standard_normal(len(NAMES))
            self._send_efforts(FORCE, "gauge", gauge, now, stamp)
            phase = np.arange(4.0)
            desired = -330.0 + 450.0 * np.sin(4.0 * now + phase) + 250.0 * np.sin(19.0 * now + phase)
            for k in self._send_efforts(DESIRED_FORCE, "desired force", desired, now, stamp):
                self._judge.desired_at[k] = now

    def _altered(self, role: str, k: int, value: float, now: float) -> list[float]:
        values = [value]
        for fault in self.active:
            if fault.kind.role == role and k in fault.dampers:
                values = [changed for v in values for changed in fault.kind.act(fault, v, k)]
        for changed in values:
            self._judge.hear_slow(role, k, changed, value, now)
        return values

    def _send_efforts(self, topic: str, role: str, values: np.ndarray, now: float, stamp: int) -> list[int]:
        """Returns the dampers whose last value is finite."""
        altered = [self._altered(role, k, float(value), now) for k, value in enumerate(values)]
        for i in range(max(map(len, altered))):
            there = [k for k, values_sent in enumerate(altered) if i < len(values_sent)]
            states = joint_state([NAMES[k] for k in there], stamp, (), [altered[k][i] for k in there])
            self._node.publish(topic, states)
        return [k for k, values_sent in enumerate(altered) if values_sent and np.isfinite(values_sent[-1])]
