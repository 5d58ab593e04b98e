"""MAT files of version 5 to 7.2 (not 7.3, which is HDF5): numbers, texts, cells and structs.

Source: MathWorks, "MAT-File Format", version 5. `scipy.io.loadmat` reads the same files, but damaged ones can crash
the whole process, which is unacceptable for users' files.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

_HEADER = 128
_MATRIX, _COMPRESSED = 14, 15
_NUMBERS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
_TEXTS = {1: "latin-1", 2: "latin-1", 4: "utf-16", 16: "utf-8", 17: "utf-16", 18: "utf-32"}
_CELL, _STRUCT, _OBJECT, _CHAR, _SPARSE = 1, 2, 3, 4, 5
_NUMERIC = range(6, 16)
_COMPLEX = 0x800


def read_mat(content: bytes) -> dict[str, object]:
    """Variables by name: arrays without dimensions of length one, str, list (cells, struct arrays) or dict (structs).

    Variables without numbers or texts (functions, tables, sparse and complex arrays) are dropped.

    Raises:
        ValueError: if the content is damaged or of another version.
    """
    if len(content) < _HEADER:
        raise ValueError("too short for a MAT file")
    order = {b"IM": "<", b"MI": ">"}.get(content[126:128])
    if order is None:
        raise ValueError("no MAT file of version 5")
    if struct.unpack_from(order + "H", content, 124)[0] != 0x0100:
        raise ValueError("a MAT file of version 7.3")
    found: dict[str, object] = {}
    for kind, data in _elements(content[_HEADER:], order):
        if kind == _COMPRESSED:
            kind, data = next(_elements(zlib.decompress(data), order), (0, b""))
        if kind == _MATRIX:
            name, value = _matrix(data, order)
            if value is not None and name and not name.startswith("__"):
                found[name] = value
    return found


def _elements(data: bytes, order: str) -> Iterator[tuple[int, bytes]]:
    """Type and bytes of each data element."""
    position = 0
    while position + 8 <= len(data):
        kind, size = struct.unpack_from(order + "II", data, position)
        if kind >> 16:  # small element: size, type and up to four bytes share eight
            kind, size, start, step = kind & 0xFFFF, kind >> 16, position + 4, 8
        else:
            start = position + 8
            step = 8 + (size if kind == _COMPRESSED else -(-size // 8) * 8)
        if start + size > len(data) or (step == 8 and size > 4 and start == position + 4):
            raise ValueError("an element reaches beyond its end")
        yield kind, data[start : start + size]
        position += step


@dataclass(frozen=True)
class _Head:
    kind: int
    flags: int
    shape: tuple[int, ...]


def _matrix(data: bytes, order: str) -> tuple[str, object]:
    """Name and value of a matrix element; None for an unsupported type."""
    if not data:
        return "", np.empty(0)
    elements = _elements(data, order)
    flags = struct.unpack_from(order + "I", _next(elements)[1])[0]
    head = _Head(flags & 0xFF, flags, tuple(np.frombuffer(_next(elements)[1], order + "i4").tolist()))
    name = _next(elements)[1].decode("latin-1")
    if len(head.shape) < 2 or min(head.shape) < 0:
        raise ValueError(f"{name} has the shape {head.shape}")
    return name, _value(head, elements, order)


def _value(head: _Head, elements: Iterator[tuple[int, bytes]], order: str) -> object:
    count = int(np.prod(head.shape, dtype=object))
    if head.kind in _NUMERIC:
        return None if head.flags & _COMPLEX else _numbers(head, *_next(elements), order)
    if head.kind == _CHAR:
        return _text(head, *_next(elements), order)
    if head.kind == _CELL:
        return [_matrix(data, order)[1] for _, data in (_next(elements) for _ in range(count))]
    if head.kind in (_STRUCT, _OBJECT):
        return _structs(head, elements, order, count)
    return None


def _numbers(head: _Head, kind: int, data: bytes, order: str) -> np.ndarray:
    if kind not in _NUMBERS:
        raise ValueError(f"numbers of the unknown type {kind}")
    flat = np.frombuffer(data, order + _NUMBERS[kind])
    return np.squeeze(flat.astype(flat.dtype.newbyteorder("=")).reshape(head.shape, order="F"))


def _text(head: _Head, kind: int, data: bytes, order: str) -> object:
    encoding = _TEXTS.get(kind, "latin-1")
    if encoding in ("utf-16", "utf-32"):
        encoding += "-le" if order == "<" else "-be"
    text = data.decode(encoding, "replace")
    rows = head.shape[0]
    if rows <= 1:
        return text
    if len(text) != np.prod(head.shape, dtype=object):
        raise ValueError(f"a text of {len(text)} characters in the shape {head.shape}")
    return ["".join(text[row::rows]) for row in range(rows)]


def _structs(head: _Head, elements: Iterator[tuple[int, bytes]], order: str, count: int) -> object:
    if head.kind == _OBJECT:
        _next(elements)
    (length,) = struct.unpack(order + "i", _next(elements)[1])
    packed = _next(elements)[1]
    if length < 1:
        raise ValueError("field names of no length")
    names = [
        packed[start : start + length].split(b"\0")[0].decode("latin-1") for start in range(0, len(packed), length)
    ]
    if names and count > 1_000_000:
        raise ValueError("more structs than a file can hold")
    found = [{name: _matrix(_next(elements)[1], order)[1] for name in names} for _ in range(count if names else 0)]
    return found[0] if len(found) == 1 else found


def _next(elements: Iterator[tuple[int, bytes]]) -> tuple[int, bytes]:
    element = next(elements, None)
    if element is None:
        raise ValueError("a variable ends too early")
    return element
