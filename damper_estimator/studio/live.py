"""What a running node says, for the page: rolling forces and residuals of all dampers, the last minutes as a bag.

ROS is in another process (``damper_estimator.node.watch``), of which this one reads lines.
"""

import json
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

import numpy as np

from damper_estimator.errors import InputError
from damper_estimator.report.plots import Figure, axis, line

SHOWN = 20.0  # s of a figure
PATIENCE = 120.0  # s until a recording must be written
_WATCHER = "damper_estimator.node.watch"
_MOST = 20_000  # points that are held of a damper


@dataclass
class LiveDamper:
    """One damper as it runs: (time s, value N) of force and residual, and what the node says of it."""

    force: deque = field(default_factory=lambda: deque(maxlen=_MOST))
    residual: deque = field(default_factory=lambda: deque(maxlen=_MOST))
    status: str = ""
    level: int = 0
    message: str = ""
    alarm: bool = False


class Live:
    """The connection to a running node; final."""

    def __init__(self, minutes: float, words: tuple[str, ...] = (sys.executable, "-m", _WATCHER)) -> None:
        """Starts the process that listens, which holds the inputs of the last ``minutes``."""
        self.dampers: dict[str, LiveDamper] = {}
        self.held: Mapping[str, float] = {}
        self._answers: deque[Mapping] = deque()
        self._lock, self._saving = threading.Condition(), threading.Lock()
        self._process = subprocess.Popen(
            [*words, "--minutes", str(minutes)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        threading.Thread(target=self._read, name="live", daemon=True).start()

    @property
    def running(self) -> bool:
        """Whether the process that listens still does."""
        return self._process.poll() is None

    def figures(self) -> dict[str, Figure]:
        """Force and residual of each damper over the last seconds."""
        with self._lock:
            return {name: _figure(damper) for name, damper in sorted(self.dampers.items())}

    def states(self) -> dict[str, tuple[str, int, str, bool]]:
        """By damper: status of the last estimate, level and message of the node's health, and the drift alarm."""
        with self._lock:
            return {
                n: (damper.status, damper.level, damper.message, damper.alarm)
                for n, damper in sorted(self.dampers.items())
            }

    def save(self, path: Path) -> int:
        """Writes the last minutes of all inputs as a recording; how many messages.

        Raises:
            InputError: where nothing came, or it cannot be written.
        """
        with self._saving:
            if not self.held.get("messages"):
                raise InputError("nothing was received yet: start the node, and what publishes the displacement")
            self._answers.clear()
            try:
                self._process.stdin.write(json.dumps({"save": str(path)}) + "\n")
                self._process.stdin.flush()
            except OSError as error:
                raise InputError("what listens to the node has ended; start the studio again") from error
            answer = self._answer()
        if "saved" not in answer:
            raise InputError(str(answer.get("failed", "the recording could not be written")))
        return int(answer["messages"])

    def close(self) -> None:
        """Ends the process that listens."""
        self._process.terminate()
        self._process.wait()

    def _answer(self) -> Mapping:
        end = monotonic() + PATIENCE
        with self._lock:
            while not self._answers and self.running and monotonic() < end:
                self._lock.wait(0.5)
            return self._answers.popleft() if self._answers else {}

    def _read(self) -> None:
        for text in self._process.stdout:
            try:
                content = json.loads(text)
            except ValueError:
                continue  # what a library has printed
            with self._lock:
                if "dampers" in content:
                    self._take(content)
                else:
                    self._answers.append(content)
                self._lock.notify_all()

    def _take(self, content: Mapping) -> None:
        self.held = content["held"]
        for name, given in content["dampers"].items():
            damper = self.dampers.setdefault(name, LiveDamper())
            for kind in ("force", "residual"):
                getattr(damper, kind).extend(zip(*given[kind], strict=True))
            damper.status, damper.level = given["status"], given["level"]
            damper.message, damper.alarm = given["message"], given["alarm"]


def _figure(damper: LiveDamper) -> Figure:
    """Times count back from the newest."""
    force, residual = (np.array(points, float).reshape(-1, 2) for points in (damper.force, damper.residual))
    newest = max((float(points[-1, 0]) for points in (force, residual) if len(points)), default=0.0)
    force, residual = (points[points[:, 0] > newest - SHOWN] for points in (force, residual))
    data = [
        line(force[:, 0] - newest, force[:, 1], "force", "@model0"),
        line(residual[:, 0] - newest, residual[:, 1], "residual", "@error", yaxis="y2"),
    ]
    layout = {
        "xaxis": axis("time before now in s", anchor="y2", range=[-SHOWN, 0.0]),
        "yaxis": axis("force in N", domain=[0.42, 1.0]),
        "yaxis2": axis("residual<br>in N", domain=[0.0, 0.34]),
        "margin": {"l": 50, "r": 8, "t": 6, "b": 34},
    }
    return {"data": data, "layout": layout}
