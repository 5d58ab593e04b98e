"""Meaning of the titles of bench and logger files: quantity, unit, damper, and whether a column is a target."""

import re
from dataclasses import dataclass

_SPELLED = {
    "displacement": {"m": "m", "cm": "cm", "mm millimeter": "mm", "um µm μm": "um", "in inch inches": "in"},
    "force": {"n newton": "N", "kn": "kN", "kgf kp kg": "kgf", "lbf lb lbs": "lbf"},
    "pressure": {"pa": "Pa", "kpa": "kPa", "mbar": "mbar", "bar": "bar", "psi": "psi"},
    "time": {"s sec secs seconds sek": "s", "ms msec": "ms", "us µs usec": "us", "ns": "ns", "min": "min", "h": "h"},
    "command": {"a amp": "A", "ma": "mA", "%": "%"},
    "temperature": {"degc °c c celsius": "degC", "k": "K", "degf °f f": "F"},
    "velocity": {"m/s m/sec": "m/s", "mm/s mm/sec": "mm/s", "in/s in/sec ips": "in/s"},
    "acceleration": {"m/s^2 m/s² m/s2": "m/s^2", "mm/s^2": "mm/s^2", "g": "g"},
    "voltage": {"v volt volts": "V", "mv": "mV"},
}
_UNITS = {
    spelling: (quantity, unit)
    for quantity, units in _SPELLED.items()
    for spellings, unit in units.items()
    for spelling in spellings.split()
}
_EXACT = {"MPa": ("pressure", "MPa"), "mPa": ("", ""), "Mpa": ("pressure", "MPa")}  # where capital letters decide
_WORDS = {
    "time": "time zeit temps tiempo tempo timestamp elapsed t",
    "displacement": "displacement disp displ position pos stroke travel weg hub federweg course deplacement"
    " desplazamiento posicion lvdt potentiometer pot crosshead actuator extension ram stringpot x s",
    "force": "force load kraft last fuerza forza effort loadcell cell strain gauge dampingforce dämpfkraft f",
    "velocity": "velocity vel speed geschwindigkeit vitesse velocidad v",
    "acceleration": "acceleration accel acc beschleunigung aceleracion a",
    "command": "current strom courant corriente coil i",
    "temperature": "temperature temp temperatur temperatura oil öltemp",
    "pressure": "pressure press druck pression presion gas p",
    "counter": "index sample samples no nr nummer number count counter point row record scan n",
}
_QUANTITY = {word: quantity for quantity, words in _WORDS.items() for word in words.split()}
_TARGET = re.compile(r"\b(set|setpoint|soll|target|desired|demand|reference|ref|command|cmd|nominal|drive)\b")
_CORNERS = {
    "front_left": "fl lf vl av-g frontleft leftfront",
    "front_right": "fr rf vr frontright rightfront",
    "rear_left": "rl lr hl rearleft leftrear",
    "rear_right": "rr hr rearright rightrear",
}
_CORNER = {word: corner for corner, words in _CORNERS.items() for word in words.split()}
_LONG = {f"{a} {b}": f"{a}_{b}" for a in ("front", "rear") for b in ("left", "right")}
_BRACKET = re.compile(r"[\[({<]\s*([^\])}>]*?)\s*[\])}>]")
_UNIT_AT_END = re.compile(r"^(.*\S)(?:\s+in\s+|\s*[/,_|:-]\s*|\s+)(\S+)$")
_ACCENTS = str.maketrans("éèêáàâóôúüíîñç", "eeeaaaoouuiinc")


@dataclass(frozen=True)
class Title:
    """The meaning of a title.

    Attributes:
        quantity: of `quantities.QUANTITIES`, or time, velocity, voltage, counter; "" if unknown.
        unit: as in a column map; "" if none is named.
        damper: corner of the vehicle; "" if none is named.
        target: whether it is the set value of a controller, not a measurement.
        clash: a contradiction in words; "" for none.
    """

    quantity: str
    unit: str
    damper: str
    target: bool
    clash: str = ""


def read_title(title: str, unit_below: str = "") -> Title:
    """The meaning of a title and of the cell below it in a row of units."""
    text, by_unit, unit = _without_unit(title)
    if unit_below and (found := _unit(unit_below)):
        by_unit, unit = found
    words = _words(text)
    quantities = [_QUANTITY[word] for word in words if word in _QUANTITY]
    long = [
        quantity for word, quantity in zip(words, map(_QUANTITY.get, words), strict=True) if quantity and len(word) > 1
    ]
    by_word = (long or quantities or [""])[-1 if not long else 0]
    damper = next((_CORNER[word] for word in words if word in _CORNER), "")
    damper = damper or next((corner for phrase, corner in _LONG.items() if phrase in " ".join(words)), "")
    target = bool(_TARGET.search(" ".join(words)))
    if by_word == "command" or (by_unit == "command" and "current" in words):
        target = False
    quantity, clash = by_unit or by_word, ""
    if by_unit == "voltage":
        quantity = by_word if by_word == "command" else "voltage"
    elif by_unit and long and by_word not in (by_unit, "counter") and not _is_compatible(by_word, by_unit):
        clash = f"{title!r} names {by_word}, but its unit {unit} is one of {by_unit}"
    return Title(quantity, unit, damper, target, clash)


def _is_compatible(word: str, unit: str) -> bool:
    """Pairs that do not contradict each other: a gauge's name on a channel of another quantity."""
    return (word, unit) in {("time", "counter"), ("displacement", "velocity"), ("displacement", "acceleration")}


def _without_unit(title: str) -> tuple[str, str, str]:
    """A title without its unit, the unit's quantity and name."""
    for inside in _BRACKET.findall(title):
        if found := _unit(inside):
            return _BRACKET.sub(" ", title), *found
    match = _UNIT_AT_END.match(title.strip())
    if match and len(match.group(1)) > 1 and (found := _unit(match.group(2))) and not _is_letter(match.group(2)):
        return match.group(1), *found
    if match and re.search(r"(_|/|,| in )\s*\S+$", title) and (found := _unit(match.group(2))):
        return match.group(1), *found
    return title, "", ""


def _is_letter(text: str) -> bool:
    return len(text) == 1


def _unit(text: str) -> tuple[str, str] | None:
    """Quantity and name of a unit."""
    text = text.strip(" []()'\"")
    found = _EXACT.get(text) or _UNITS.get(text.lower())
    if not found or not found[0]:
        return None
    return found


def _words(text: str) -> list[str]:
    """A title's words in lower case: also those of CamelCase and with_underscores."""
    text = re.sub(r"(?<=[a-zäöü])(?=[A-Z])", " ", _BRACKET.sub(" ", text))
    return [word for word in re.split(r"[^a-z0-9äöüß]+", text.lower().translate(_ACCENTS)) if word]


def is_unit(text: str) -> bool:
    """Whether a cell is the name of a unit, with or without brackets."""
    return _unit(text) is not None
