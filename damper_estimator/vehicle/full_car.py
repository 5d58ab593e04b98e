"""A whole car with seven degrees of freedom: heave, pitch and roll of the body, and four wheels; from a file.

With z upwards, everything measured from the loaded rest, wheels in order front left, front right, rear left, right:

    b_i = z + x_i pitch + y_i roll                 body above wheel i; x forwards, y to the left
    S_i = k e_i + k_a (e_i - e_other) + r F_i      e_i = b_i - w_i its extension, e_other that of the axle's other wheel
    m z'' = -sum S_i,   I_p pitch'' = -sum x_i S_i,   I_r roll'' = -sum y_i S_i
    m_w w_i'' = S_i + k_t (p_i - w_i) + c_t (p_i' - w_i')

with the nose and the left side up for positive angles, p_i the post under the wheel, F_i the damper's force less that
at rest, at its travel r e_i.
"""

from dataclasses import dataclass, fields
from pathlib import Path
from typing import get_type_hints

import numpy as np

from damper_estimator.errors import InputError, did_you_mean
from damper_estimator.files import read_yaml
from damper_estimator.share import share_path

WHEELS = ("front_left", "front_right", "rear_left", "rear_right")
"""Order of all arrays over wheels."""

LIBRARY = "config/vehicles"


@dataclass(frozen=True)
class Body:
    """The sprung mass (kg) and its moments of inertia about the centre of gravity (kg m^2)."""

    mass: float
    pitch_inertia: float
    roll_inertia: float


@dataclass(frozen=True)
class Axle:
    """One axle; rates per wheel, at the wheel."""

    distance: float  # m, from the centre of gravity
    track: float  # m
    wheel_mass: float  # kg
    spring_rate: float  # N/m
    anti_roll_rate: float  # N/m, 0 is allowed
    tyre_rate: float  # N/m
    tyre_damping: float  # N s/m, 0 is allowed
    damper_ratio: float  # 1, damper travel over wheel travel


_MAY_BE_ZERO = {"anti_roll_rate", "tyre_damping"}


@dataclass(frozen=True)
class FullCar:
    """A car."""

    name: str
    source: str
    body: Body
    front: Axle
    rear: Axle

    @property
    def axles(self) -> tuple[Axle, Axle, Axle, Axle]:
        """Of each wheel."""
        return self.front, self.front, self.rear, self.rear

    def over(self, name: str) -> np.ndarray:
        """A parameter of the axles over the wheels, (4,)."""
        return np.array([getattr(axle, name) for axle in self.axles])

    @property
    def body_heights(self) -> np.ndarray:
        """(4, 7): b_i from the degrees of freedom (heave, pitch, roll, wheels)."""
        x = np.array([1.0, 1.0, -1.0, -1.0]) * self.over("distance")
        y = np.array([0.5, -0.5, 0.5, -0.5]) * self.over("track")
        return np.column_stack([np.ones(4), x, y, np.zeros((4, 4))])

    @property
    def extensions(self) -> np.ndarray:
        """(4, 7): e_i from the degrees of freedom."""
        return self.body_heights - np.column_stack([np.zeros((4, 3)), np.eye(4)])

    @property
    def masses(self) -> np.ndarray:
        """(7,) kg and kg m^2."""
        body = self.body
        return np.concatenate([[body.mass, body.pitch_inertia, body.roll_inertia], self.over("wheel_mass")])

    @property
    def stiffness(self) -> np.ndarray:
        """(7, 7) N/m: springs, anti-roll bars and tyres."""
        extension = self.extensions
        difference = np.stack([extension[0] - extension[1], extension[2] - extension[3]])
        bars = np.diag([self.front.anti_roll_rate, self.rear.anti_roll_rate])
        tyres = np.diag(np.concatenate([np.zeros(3), self.over("tyre_rate")]))
        springs = extension.T @ np.diag(self.over("spring_rate")) @ extension
        return springs + difference.T @ bars @ difference + tyres


def library_vehicles() -> dict[str, Path]:
    """Path of every installed car by name."""
    return {path.stem: path for path in sorted(share_path(LIBRARY).glob("*.yaml"))}


def load_car(name_or_path: str | Path) -> FullCar:
    """Reads a car: a YAML file, or the name of an installed car.

    Raises:
        InputError: one line with the file, all faults and the remedy.
    """
    path = Path(name_or_path)
    if not path.exists() and path.suffix not in (".yaml", ".yml"):
        library = library_vehicles()
        if str(name_or_path) not in library:
            near = did_you_mean(str(name_or_path), library) or f"; available: {', '.join(library)}"
            raise InputError(f"{name_or_path}: is neither a file nor a car's name{near}")
        path = library[str(name_or_path)]
    content = read_yaml(path)
    if not isinstance(content, dict):
        raise InputError(f"{path}: is not a file of a car; it needs the keys {', '.join(get_type_hints(FullCar))}")
    faults: list[str] = []
    car = FullCar(
        str(content.get("name", path.stem)),
        str(content.get("source", "")),
        _part(Body, "body", content, faults),
        _part(Axle, "front", content, faults),
        _part(Axle, "rear", content, faults),
    )
    faults += [f"{key} is an unknown key" for key in content if key not in get_type_hints(FullCar)]
    if faults:
        raise InputError(f"{path}: {'; '.join(faults)}; correct the file ({LIBRARY}/compact_car.yaml is an example)")
    return car


def _part(kind: type, key: str, content: dict, faults: list[str]):
    """A part from the file's mapping under ``key``; appends its faults to ``faults``."""
    given = content.get(key)
    if not isinstance(given, dict):
        faults.append(f"{key} is missing or not a mapping")
        given = {}
    names = [field.name for field in fields(kind)]
    faults += [f"{key}.{name} is unknown (allowed: {', '.join(names)})" for name in given if name not in names]
    values = {}
    for name in names:
        value = given.get(name)
        number = isinstance(value, int | float) and not isinstance(value, bool) and np.isfinite(value)
        if number and (value > 0.0 or (value == 0.0 and name in _MAY_BE_ZERO)):
            values[name] = float(value)
        else:
            values[name] = np.nan
            if given:
                faults.append(f"{key}.{name} = {value!r} is not a number above 0")
    return kind(**values)
