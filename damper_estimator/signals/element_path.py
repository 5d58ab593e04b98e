"""The path of an element that a message names: ``position[front_left]``."""

import json
import re

_PLAIN = re.compile(r"[^\W\d][\w ./:-]*")  # a name that needs no quotation marks


def named_element(field: str, name: str) -> str:
    """The path of the element of an array that a message gives this name, whatever characters the name has."""
    is_plain = _PLAIN.fullmatch(name) and name == name.strip()
    return f"{field}[{name if is_plain else json.dumps(name, ensure_ascii=False)}]"
