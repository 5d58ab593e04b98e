"""Parts of a bench test as recordings with the default topics."""

import string
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.recordings.bench import Part
from damper_estimator.recordings.encode import accelerations, floats, joint_states, pressures, temperatures
from damper_estimator.recordings.writer import BagWriter, Stream

JOINT_STATE = "sensor_msgs/msg/JointState"
_SECOND = 1_000_000_000
_AHEAD = 1_000  # ns; a slow channel is logged before the sample that it belongs to
_SLOW = {
    "command": ("current", "std_msgs/msg/Float64", lambda stamps, values: floats(values)),
    "temperature": ("temperature", "sensor_msgs/msg/Temperature", temperatures),
    "pressure": ("pressure", "sensor_msgs/msg/FluidPressure", pressures),
    "acceleration": ("acceleration", "geometry_msgs/msg/AccelStamped", accelerations),
}


def planned_paths(parts: Sequence[Part], templates: Sequence[str | None], output: Path) -> list[Path]:
    """The path of each part: ``output`` itself if it ends in ``.mcap``, else in the folder ``output``.

    Args:
        parts: of all files.
        templates: name of each part's recording; None is ``{stem}``, or ``{stem}_{part}`` if a file has several.

    Raises:
        InputError: for several parts and one file, for equal names, and for unknown placeholders.
    """
    if output.suffix == ".mcap":
        if len(parts) > 1:
            raise InputError(f"{output}: {len(parts)} parts do not fit into one recording; name a folder with -o")
        return [output]
    names = [_name(part, template) for part, template in zip(parts, templates, strict=True)]
    doubles = sorted({name for name in names if names.count(name) > 1})
    if doubles:
        raise InputError(
            f"{output}: several parts would be named {', '.join(doubles)}; put {{part}} into name in the map"
        )
    return [output / f"{name}.mcap" for name in names]


class _Names(string.Formatter):
    """Writes numbers in short form (0.25, 1), not as Python (1.0); final."""

    def format_field(self, value: object, spec: str) -> str:
        return super().format_field(value, spec or ("g" if isinstance(value, float) else ""))


def _name(part: Part, template: str | None) -> str:
    template = template or ("{stem}" if part.parts == 1 else "{stem}_{part}")
    constants = {
        name: value
        for channels in reversed(part.dampers.values())
        for name, value in channels.items()
        if not np.ndim(value)
    }
    known = {"stem": part.stem, "part": part.number, **constants}
    try:
        name = _Names().format(template, **known)
    except (LookupError, ValueError) as error:
        what = f"name {template!r} cannot be filled in ({error})"
        raise InputError(f"{part.source}: {what}; it can use {', '.join(f'{{{key}}}' for key in known)}") from error
    if not name or "/" in name or "\0" in name:
        raise InputError(f"{part.source}: {name!r} is no name for a recording; correct name in the column map")
    return name


def write_part(part: Part, path: Path) -> None:
    """Writes one recording with the topics of a vehicle: ``/suspension/displacement``, ``/suspension/force``, ...

    Constant channels come once a second and with the first sample; slow channels are logged just before the sample.

    Raises:
        InputError: if it cannot be written.
    """
    with BagWriter(path) as writer:
        writer.write_streams([*_slow(part), *_fast(part)])


def _fast(part: Part) -> Iterator[Stream]:
    for quantity, field in (("displacement", "position"), ("force", "effort")):
        columns = {damper: channels[quantity] for damper, channels in part.dampers.items() if quantity in channels}
        if columns:
            values = np.column_stack(list(columns.values()))
            messages = joint_states(list(columns), part.stamps, **{field: values})
            yield Stream(f"/suspension/{quantity}", JOINT_STATE, part.stamps, messages)


def _slow(part: Part) -> Iterator[Stream]:
    for damper, channels in part.dampers.items():
        for quantity, (topic, type_name, encode) in _SLOW.items():
            if quantity in channels:
                stamps, values = _samples(part, channels[quantity])
                yield Stream(f"/suspension/{damper}/{topic}", type_name, stamps - _AHEAD, encode(stamps, values))


def _samples(part: Part, values: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    if np.ndim(values):
        known = np.isfinite(values)
        return part.stamps[known], values[known]
    _, first = np.unique((part.stamps - part.stamps[0]) // _SECOND, return_index=True)
    stamps = part.stamps[np.sort(first)]
    return stamps, np.full(len(stamps), float(values))
