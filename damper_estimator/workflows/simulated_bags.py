"""Bags of simulated records, their true signals, and a signal map: the files of ``synth`` and ``ride``."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from damper_estimator.files import write_text
from damper_estimator.plant import Channel, Record, Sensors
from damper_estimator.recordings import BagWriter, Stream, floats, joint_states, temperatures

EPOCH = 1_700_000_000_000_000_000
"""ns, begin of simulated recordings."""

DISPLACEMENT, FORCE = "/suspension/displacement", "/suspension/force"
TRUE_DISPLACEMENT, TRUE_FORCE = "/truth/displacement", "/truth/force"


def write_record(path: Path, records: Mapping[str, Record], with_current: bool) -> None:
    """Writes one bag; ``records`` by damper name, recorded with one clock.

    Raises:
        InputError: if the file cannot be written.
    """
    names, sensed = list(records), [record.sensed for record in records.values()]
    streams = [
        _states(DISPLACEMENT, names, [record.displacement for record in sensed], "position"),
        _states(FORCE, names, [record.force for record in sensed], "effort"),
    ]
    for name, record in zip(names, sensed, strict=True):
        temperature = record.temperature
        messages = temperatures(EPOCH + temperature.stamp, temperature.value)
        topic = f"/suspension/{name}/temperature"
        streams.append(Stream(topic, "sensor_msgs/msg/Temperature", EPOCH + temperature.log, messages))
        if with_current:
            coil = record.current
            streams.append(_floats(f"/suspension/{name}/current", coil))
    with BagWriter(path) as bag:
        bag.write_streams(streams)


def write_truth(path: Path, records: Mapping[str, Record]) -> None:
    """Writes the noise-free displacement and force at the displacement's stamps, as a bag that no analysis reads."""
    names, sensed = list(records), [record.sensed for record in records.values()]
    with BagWriter(path) as bag:
        bag.write_streams([
            _states(TRUE_DISPLACEMENT, names, [record.true_displacement for record in sensed], "position"),
            _states(TRUE_FORCE, names, [record.true_force for record in sensed], "effort"),
        ])  # fmt: skip


def write_signal_map(path: Path, name: str, sensors: Sensors, with_current: bool) -> None:
    """Writes the signal map of one damper whose gauge also measures a coil spring."""
    spring = f"spring_rate: {sensors.spring_rate}, preload: {sensors.preload}"
    lines = [
        "dampers:",
        f"  {name}:",
        f'    displacement: {{topic: {DISPLACEMENT}, field: "position[{name}]"}}',
        f'    force: {{topic: {FORCE}, field: "effort[{name}]", {spring}}}',
        f"    temperature: {{topic: /suspension/{name}/temperature, field: temperature}}",
    ]
    if with_current:
        lines.append(f"    command: {{topic: /suspension/{name}/current, field: data, unit: A}}")
    write_text(path, "\n".join(lines) + "\n")


def _states(topic: str, names: list[str], channels: list[Channel], field: str) -> Stream:
    first = channels[0]
    values = np.stack([channel.value for channel in channels], axis=1)
    return Stream(
        topic,
        "sensor_msgs/msg/JointState",
        EPOCH + first.log,
        joint_states(names, EPOCH + first.stamp, **{field: values}),
    )


def _floats(topic: str, channel: Channel) -> Stream:
    return Stream(topic, "std_msgs/msg/Float64", EPOCH + channel.log, floats(channel.value))
