"""Compiles a model into the chain's flat program: tables of operations, parameters, settings and states."""

from dataclasses import dataclass, replace

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.model import chain
from damper_estimator.model.ahead import wait_for_loops
from damper_estimator.model.element import Element, walk
from damper_estimator.model.kernels import addresses


@dataclass(frozen=True)
class Program:
    """A model ready to run; see ``chain.run``.

    Attributes:
        functions: the result of ``function_list``.
        table: (m, 13) int64.
        parameters, settings: flat float64 arrays.
        motions, forces, states: sizes of the registers and of the state.
        rows: for every entry of the model in order of ``walk``, its row in the table.
        series: whether the program has a series operation.
    """

    functions: np.ndarray | list
    table: np.ndarray
    parameters: np.ndarray
    settings: np.ndarray
    motions: int
    forces: int
    states: int
    rows: tuple[int, ...]
    series: bool

    def __reduce__(self) -> str:
        raise TypeError("a program holds addresses of this process: send the model, which compiles it again")


class _Layout:
    """Collects the operations of one program."""

    def __init__(self):
        self.rows: list[list[int]] = []
        self.kernels: list = []
        self.parameters: list[np.ndarray] = []
        self.settings: list[np.ndarray] = []
        self.sizes = {"p": 0, "s": 0, "z": 0}
        self.motions = 0
        self.forces = 1
        self.entry_rows: list[int] = []

    def add(self, code: int, motion: int, motion_up: int, force: int, force_up: int, element: Element | None) -> int:
        """Appends an operation; returns its row."""
        values = np.zeros(0) if element is None else packed(element)
        settings = np.zeros(0) if element is None else element.effect.prepare(element.parameters, element.settings)
        states = 0 if element is None else element.effect.states + chain.SERIES_STATES * (code == chain.SERIES)
        kernel = 0
        if element is not None and element.effect.kernel is not None:
            kernel = len(self.kernels)
            self.kernels.append(element.effect.kernel)
        span = []
        for key, size in (("p", values.size), ("s", settings.size), ("z", states)):
            span += [self.sizes[key], self.sizes[key] + size]
            self.sizes[key] += size
        self.parameters.append(values)
        self.settings.append(np.asarray(settings, float))
        self.rows.append([code, kernel, 0, motion, motion_up, force, force_up, *span])
        return len(self.rows) - 1

    def lay(self, elements: tuple[Element, ...], motion: int, force: int) -> None:
        """Appends the operations of a list of entries."""
        for element in elements:
            if element.effect.kind == "scaled":
                self.entry_rows.append(self.add(chain.ENTER, motion, motion, force, force, None))
                self.entry_rows += [
                    self.add(chain.SCALE, motion, motion, force, force, entry) for entry in element.path
                ]
                continue
            if element.effect.kind not in ("path", "series"):
                code = chain.CHANNEL if element.effect.kind == "channel" else chain.RUN
                self.entry_rows.append(self.add(code, motion, motion, force, force, element))
                continue
            series = element.effect.kind == "series"
            own_motion = self.new_motion() if series or changes_motion(element.path) else motion
            own_force = self.new_force()
            codes = (chain.SERIES, chain.SOLVE) if series else (chain.ENTER, chain.LEAVE)
            begin = self.add(codes[0], own_motion, motion, own_force, force, element if series else None)
            self.entry_rows.append(begin)
            self.lay(element.path, own_motion, own_force)
            end = self.add(codes[1], own_motion, motion, own_force, force, None)
            self.rows[begin][chain.PARTNER], self.rows[end][chain.PARTNER] = end, begin

    def new_motion(self) -> int:
        """A register for a private copy of the motion."""
        self.motions += 1
        return self.motions

    def new_force(self) -> int:
        """A register for the force of a path."""
        self.forces += 1
        return self.forces - 1


def function_list(kernels: list, series: bool) -> np.ndarray | list:
    """The functions that ``chain.run`` calls for a program with these kernels; ``series``: whether it has a series
    operation."""
    wait_for_loops(series)
    return addresses([chain.block_loop, chain.sample_loop if series else None], kernels)


def packed(element: Element) -> np.ndarray:
    """The parameters of an entry in the kernel's order, vectors flattened."""
    return np.concatenate([np.atleast_1d(value) for value in element.parameters.values()] or [np.zeros(0)])


def changes_motion(elements: tuple[Element, ...]) -> bool:
    """Whether a list needs a separate motion, because one of its entries rewrites it."""
    return any(element.effect.kind == "input" for element in elements)


def compile_program(elements: tuple[Element, ...]) -> Program:
    """The program of a list of entries.

    Raises:
        InputError: for a channel effect inside a path, where it would act on only a part of the force.
    """
    inside = [e.effect.name for element in elements for e in walk(element.path) if e.effect.kind == "channel"]
    if inside:
        raise InputError(f"{', '.join(inside)}: an effect of the measurement chain cannot be inside a path")
    if any(element.effect.kind == "scaled" for element in elements):
        raise InputError("scaled must be first in the path of a series effect")
    layout = _Layout()
    if changes_motion(elements):
        motion, force = layout.new_motion(), layout.new_force()
        layout.add(chain.ENTER, motion, 0, force, 0, None)
        layout.lay(elements, motion, force)
        layout.add(chain.LEAVE, motion, 0, force, 0, None)
    else:
        layout.lay(elements, 0, 0)
    table = np.array(layout.rows, np.int64).reshape(-1, chain.COLUMNS)
    series = bool((table[:, chain.CODE] == chain.SERIES).any())
    return Program(
        functions=function_list(layout.kernels, series),
        table=table,
        parameters=np.concatenate([*layout.parameters, np.zeros(0)]),
        settings=np.concatenate([*layout.settings, np.zeros(0)]),
        motions=layout.motions,
        forces=layout.forces,
        states=layout.sizes["z"],
        rows=tuple(layout.entry_rows),
        series=series,
    )


def refilled(program: Program, elements: tuple[Element, ...]) -> Program:
    """The same program with the values of ``elements``, which must have the structure that it was compiled from."""
    entries = [element for element in walk(elements) if element.effect.kernel is not None]
    parameters = [packed(element) for element in entries]
    settings = [np.asarray(e.effect.prepare(e.parameters, e.settings), float) for e in entries]
    return replace(
        program,
        parameters=np.concatenate([*parameters, np.zeros(0)]),
        settings=np.concatenate([*settings, np.zeros(0)]),
    )
