"""A car with semi-active dampers for the tests of their commands: models, motion, desired forces, currents."""

import itertools
from pathlib import Path

import numpy as np
import yaml
from rig import MS, START, Rig

from damper_estimator.model import load_model
from damper_estimator.model.force_table import force_table, write_tables
from damper_estimator.recordings import floats, joint_states

DAMPERS = ("left", "right")
SAFE = 0.25
DESIRED = 700.0  # N, which needs a current well above the safe one
FIT = {
    "bags": ["test.mcap"], "date": "2026-01-01", "cutoff": 60.0, "residual_stddev": 20.0,
    "region": {
        "displacement": [-0.1, 0.1], "velocity": [-2.0, 2.0], "acceleration": [-1e3, 1e3], "command": [0.0, 2.0],
    },
}  # fmt: skip


def semi_active_parameters(folder: Path, dampers: tuple[str, ...] = DAMPERS) -> dict[str, object]:
    """Parameters of an estimator of identified semi-active dampers; its files are written to the folder."""
    effects = [{"command_lag": {}}, {"viscous": {"rate": 800.0}}, {"semi_active_squash": {"gain": 600.0}}]
    models = folder / "models"
    models.mkdir(parents=True)
    for name in dampers:
        content = {"name": name, "source": "test", "effects": effects, "fit": FIT}
        (models / f"{name}.yaml").write_text(yaml.safe_dump(content))
    command = {name: {"topic": f"suspension/{name}/current", "limits": [0.0, 2.0]} for name in dampers}
    signals = {"dampers": {name: {"command": command[name]} for name in dampers}}
    (folder / "map.yaml").write_text(yaml.safe_dump(signals))
    return {
        "model": str(models), "signals": str(folder / "map.yaml"), "safe_current": SAFE, "desired_force_timeout": 10.0,
        "stale_after": 0.2, "command_lag": 0.0,  # the car reports one current, regardless of the commands
    }  # fmt: skip


def by_table(folder: Path) -> str:
    """A table whose force grows with the current."""
    model = load_model("semi_active_on_mount")
    forces = force_table(model, np.array([-0.5, -0.1, 0.1, 0.5]), commands=(0.0, 2.0))
    return str(write_tables(model, forces, folder / "tables")[0])


class Car:
    """Drives an estimator and receives its commands; final.

    Attributes:
        commands: A, all received ones, by damper; ``sources``: from ``~/command``.
    """

    def __init__(self, rig: Rig, dampers: tuple[str, ...] = DAMPERS, namespace: str = "", driver: bool = False) -> None:
        """With ``driver`` another node reports the flowing current."""
        from damper_msgs.msg import DamperCommand
        from std_msgs.msg import Float64

        self._rig, self._dampers, self._namespace = rig, dampers, namespace
        self.commands: dict[str, list[float]] = {name: [] for name in dampers}
        self.sources: dict[str, int] = {}
        self._number = itertools.count()
        rig.node.create_subscription(
            DamperCommand, f"{namespace}/damper_estimator/command",
            lambda message: self.sources.update(zip(message.name, message.source, strict=True)), 1000,
        )  # fmt: skip
        for name in dampers:
            rig.node.create_subscription(
                Float64, self.topic(name, "current_command"),
                lambda message, name=name: self.commands[name].append(message.data), 1000,
            )  # fmt: skip
        self._flowing = [] if driver else [self._publisher(self.topic(name, "current"), "std_msgs/msg/Float64")
                                           for name in dampers]  # fmt: skip
        self._displacement = self._publisher(f"{namespace}/suspension/displacement")
        self._desired = self._publisher(f"{namespace}/damper_estimator/desired_force")

    def topic(self, name: str, end: str) -> str:
        return f"{self._namespace}/suspension/{name}/{end}"

    def _publisher(self, topic: str, kind: str = "sensor_msgs/msg/JointState"):
        return self._rig.publisher_unmatched(topic, kind)

    def move(self, desired: float | None = DESIRED) -> None:
        """One sample of all dampers 2 ms after the last, the flowing current, and a desired force."""
        number = next(self._number)
        stamp = np.array([START + 2 * number * MS])
        for publisher in self._flowing:
            publisher.publish(floats(np.array([0.5]))[0])
        position = np.full((1, len(self._dampers)), 0.02 * np.sin(0.02 * number))
        self._displacement.publish(joint_states(list(self._dampers), stamp, position=position)[0])
        if desired is not None:
            effort = np.full((1, len(self._dampers)), desired)
            self._desired.publish(joint_states(list(self._dampers), stamp, effort=effort)[0])
        self._rig.listen(0.002)

    def drive_until(self, condition, what: str, desired: float | None = DESIRED) -> None:
        """Moves until a condition holds."""
        for _ in range(50_000):
            self.move(desired)
            if condition():
                return
        raise AssertionError(f"{what} did not come; commanded {[commands[-3:] for commands in self.commands.values()]}")

    def energise(self) -> None:
        """Drives until every damper is commanded another current than the safe one."""
        self.drive_until(
            lambda: all(commands and commands[-1] > 2.0 * SAFE for commands in self.commands.values()),
            "currents above the safe one",
        )

    def last(self) -> dict[str, float]:
        """The last commands."""
        return {name: commands[-1] for name, commands in self.commands.items()}
