"""Fuzzing of all readers of external input: bags, bench files, YAML, messages, the node's parameters.

Coverage-guided (atheris, if installed), else by random mutation of valid examples. Any input can be refused with an
`InputError`; any other exception is a finding that is saved in out/fuzz with its traceback, and the run continues.

    python benchmarks/fuzz.py TARGET SECONDS
"""

import hashlib
import logging
import os
import random
import sys
import tempfile
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np

os.environ.setdefault("NUMBA_DISABLE_JIT", "1")  # compiled code shows no coverage

try:
    import atheris
except ImportError:
    atheris = None

SLOW = 20.0  # s, a longer duration for one input is a finding
LONGEST = 60_000  # bytes
PROGRESS_EVERY = 10.0  # s
ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "fuzz"


class Findings:
    """Runs a target on inputs and saves unexpected exceptions, once per source line; final."""

    def __init__(self, target: str, run: Callable[[bytes], None]) -> None:
        self._target, self._run = target, run
        self.kinds: dict[str, str] = {}
        self._inputs, self._reported = 0, 0.0

    def take(self, data: bytes) -> None:
        """Runs one input."""
        from damper_estimator.errors import InputError

        self._inputs += 1
        begin = time.monotonic()
        if begin > self._reported + PROGRESS_EVERY:
            self._reported = begin
            print(f"{self._target}: {self._inputs} inputs, {len(self.kinds)} findings", flush=True)
        try:
            self._run(data)
        except InputError as error:
            if "\n" in str(error):
                self._keep(data, "an error of several lines", str(error))
        except Exception as error:
            frames = traceback.extract_tb(error.__traceback__)
            last = ([frame for frame in frames if "damper_estimator" in frame.filename] or frames)[-1]
            self._keep(data, f"{type(error).__name__} at {last.filename}:{last.lineno}", traceback.format_exc())
        if time.monotonic() - begin > SLOW:
            self._keep(data, f"slow: {time.monotonic() - begin:.0f} s", "")

    def _keep(self, data: bytes, kind: str, text: str) -> None:
        if kind in self.kinds:
            return
        OUT.mkdir(parents=True, exist_ok=True)
        path = OUT / f"{self._target}-{hashlib.sha1(data).hexdigest()[:12]}"
        path.write_bytes(data)
        path.with_suffix(".txt").write_text(f"{kind}\n{text}")
        self.kinds[kind] = str(path)
        print(f"{self._target}: {kind}: {path}", file=sys.stderr, flush=True)


def small_bag(folder: Path, compressed: bool) -> bytes:
    """A short recording whose chunks a mutation can reach unless compressed."""
    from mcap.writer import CompressionType, Writer

    from damper_estimator.recordings import BagWriter, joint_states
    from damper_estimator.recordings.definitions import builtin_schema

    path = folder / "seed.mcap"
    stamps = np.arange(1, 9) * 1_000_000
    messages = joint_states(["a", "b"], stamps, position=np.arange(16.0).reshape(8, 2))
    kind = "sensor_msgs/msg/JointState"
    if compressed:
        with BagWriter(path) as writer:
            writer.write_messages("/suspension/displacement", kind, stamps, messages)
        return path.read_bytes()
    with open(path, "wb") as file:
        writer = Writer(file, chunk_size=400, compression=CompressionType.NONE, enable_crcs=False)
        writer.start("ros2", "x")
        number = writer.register_schema(kind, "ros2msg", builtin_schema(kind).text.encode())
        channel = writer.register_channel("/suspension/displacement", "cdr", number)
        for stamp, message in zip(stamps.tolist(), messages, strict=True):
            writer.add_message(channel, stamp, message, stamp)
        writer.finish()
    return path.read_bytes()


def bags(folder: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Reading of mcap and sqlite3 files, and of the channels of a damper in them."""
    from damper_estimator.errors import InputError
    from damper_estimator.recordings import open_bag
    from damper_estimator.signals import SignalMap, measure
    from damper_estimator.signals.channels import signals_for

    path = folder / "x.mcap"

    def run(data: bytes) -> None:
        path.write_bytes(data)
        with open_bag(path) as bag:
            for batch in bag.batches(size=5):
                for topic in bag.topics:
                    try:
                        batch.columns(topic.name, ["position[a]", "position[1]"])
                        list(batch.messages(topic.name))
                    except InputError:
                        pass
            for damper in signals_for(bag, SignalMap()).dampers:
                measure(bag, signals_for(bag, SignalMap()), damper)

    return run, [small_bag(folder, False), small_bag(folder, True)]


def yaml_examples(folder: str) -> list[bytes]:
    """The files of a folder of configurations."""
    return [path.read_bytes() for path in sorted((ROOT / "config" / folder).glob("*.yaml"))]


def models(folder: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Model files; an accepted model must run with finite forces or a degraded status."""
    from damper_estimator.model import load_model
    from damper_estimator.model.model_files import model_yaml, parse_model
    from damper_estimator.runtime import Line, deployed

    path = folder / "x.yaml"

    def run(data: bytes) -> None:
        path.write_bytes(data)
        model = load_model(path)
        import yaml

        assert parse_model(yaml.safe_load(model_yaml(model)), "again").slots == model.slots
        line = Line()
        line.add("one", deployed(model, 60.0, 0.1))
        for i in range(4):
            line.step(i * 1_000_000, np.array([0.01 * i]), np.ones(1, bool))
            assert np.isfinite(line.output.numbers[0, 3]).all(), "a non-finite force"

    return run, yaml_examples("models")


def maps(folder: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Signal maps and column maps."""
    from damper_estimator.errors import InputError
    from damper_estimator.recordings import load_column_maps
    from damper_estimator.signals import load_signal_map, parse_signal_map, signal_map_yaml

    path = folder / "x.yaml"

    def run(data: bytes) -> None:
        path.write_bytes(data)
        try:
            load_column_maps(path)
        except InputError:
            pass
        signal_map = load_signal_map(path)
        import yaml

        again = parse_signal_map(yaml.safe_load(signal_map_yaml(signal_map)), signal_map.where)
        assert again == signal_map, "the map changes when written and read"

    example = b"""filter: {cutoff: 60.0, band: none, fusion: {displacement_noise: 1.0e-5, offset_drift: 0.1}}
dampers:
  a:
    displacement: {topic: /x, field: "position[a]", scale: 2.0, offset: 0.1, skew: 0.001}
    force: {topic: /f, field: "effort[0]", spring_rate: 28000.0, preload: -3000.0}
    command: {table: {raw: [0, 1], value: [0.0, 2.0]}, unit: A, limits: [0.0, 1.8]}
use: [{from: 0.0, to: 9.0}]
"""
    return run, [example, *yaml_examples("signals"), *yaml_examples("columns")]


def bench(folder: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Import of text and MAT files; the first byte chooses the column map."""
    import io

    from scipy.io import savemat

    from damper_estimator.recordings import load_column_maps, read_parts

    rules = []
    for number, clock in enumerate(("{column: 1, unit: s}", "{rate: 100.0}")):
        path = folder / f"map_{number}.yaml"
        path.write_text(
            f"time: {clock}\ndampers:\n  one:\n    displacement: {{column: 2, unit: mm}}\n"
            "    force: {column: 3, unit: N}\n"
        )
        rules.append(load_column_maps(path))
    table = "\n".join(f"{0.01 * i:.4f},{i % 7:.3f},{10.0 * i:.2f}" for i in range(40)).encode()
    binary = io.BytesIO()
    savemat(binary, {"t": 0.01 * np.arange(40.0), "x": np.arange(40.0), "F": np.ones(40)})

    def run(data: bytes) -> None:
        name = folder / ("x.mat" if data[:1] > b"\x80" else "x.csv")
        name.write_bytes(data[1:])
        chosen = rules[(data[0] if data else 0) % len(rules)]
        for part in read_parts(name, chosen.for_file(name.name)):
            assert part.stamps.size

    heads = [b"time;x;F\n" + table.replace(b",", b";"), b"t,x,F\ns,mm,N\n" + table, table.replace(b",", b"\t")]
    return run, [*(bytes([n % 2]) + head for n, head in enumerate(heads)), b"\x90" + binary.getvalue()]


def wire(_: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Messages of the node, with changing names."""
    from damper_estimator.model import load_model
    from damper_estimator.node.displacement import Arrival, DisplacementInput, Estimator, names_in
    from damper_estimator.recordings import joint_states
    from damper_estimator.recordings.cdr_layout import MalformedMessage
    from damper_estimator.runtime import deployed
    from damper_estimator.signals import default_signals

    model = deployed(load_model("coulomb"), 60.0, 0.1)
    rules = SimpleNamespace(safe_current=0.0, desired_force_timeout=0.1, command_extrapolating=False, command_lag=0.0,
                            horizon=0.02, lead=0.0)  # fmt: skip
    source = DisplacementInput([Estimator(name, default_signals(name), model) for name in ("a", "b")], rules)

    def run(data: bytes) -> None:
        try:
            names_in(data)
            source.take(data, Arrival(0.0))
        except MalformedMessage:
            return
        force = source.line.output.numbers[0, 3]
        assert np.isfinite(force[source.line.output.verdict[0] == 0]).all(), "a non-finite force"

    stamps = np.arange(3) * 10**6
    seeds = joint_states(["a", "b"], stamps, position=np.ones((3, 2)))
    seeds += joint_states([], stamps[:1]) + joint_states(["b", "c", "a"], stamps[:1], effort=np.ones((1, 3)))
    return run, seeds


def parameters(_: Path) -> tuple[Callable[[bytes], None], list[bytes]]:
    """Parameters set on a running node: each request is accepted or refused with a reason."""
    import rclpy
    from rclpy.parameter import Parameter

    from damper_estimator.node.estimator_node import EstimatorNode
    from damper_estimator.node.settings import DECLARATIONS

    rclpy.init(args=["--ros-args", "-p", "model:=coulomb", "-p", "dampers:=[a]", "--log-level", "fatal"])
    node = EstimatorNode()
    node.start()
    words = ["", "coulomb", "linear_viscous", "a", "/tmp", "/dev/null", "\0", "config/models", "é" * 9, "x" * 5000]
    numbers = [0.0, -1.0, 60.0, 0.1, 1e-6, 1e308, float("inf"), float("nan"), -0.0, 5e-324]

    def value(chance: random.Random) -> object:
        kind = chance.randrange(7)
        return (
            chance.choice(words), chance.choice(numbers), chance.choice([0, 1, -1, 2**63 - 1, -(2**63)]),
            chance.random() < 0.5, [chance.choice(words) for _ in range(chance.randrange(4))] or None,
            chance.choice([chance.random() * 10 ** chance.randrange(-9, 9), None]), [1.0, float("nan")],
        )[kind]  # fmt: skip

    def run(data: bytes) -> None:
        chance = random.Random(data)
        names = chance.sample([*DECLARATIONS, "nonsense"], chance.randrange(1, 4))
        chosen = [Parameter(name, value=value(chance)) for name in names]
        try:
            result = node.set_parameters_atomically(chosen)
        except rclpy.exceptions.ParameterNotDeclaredException:
            return
        assert result.successful or result.reason, "refused without a reason"
        assert node.state.estimation is not None and node.get_parameter("model").value

    return run, [bytes([i]) for i in range(3)]


TARGETS = {"bags": bags, "models": models, "maps": maps, "bench": bench, "wire": wire, "parameters": parameters}


WORDS = (b"nan", b"-1", b"1e309", b"{", b"[", b"null", b": ", b"\xff" * 8, b"0x", b"&a *a")


def mutated(seeds: list[bytes], chance: random.Random) -> bytes:
    """A valid example with bytes flipped, cut, doubled or mixed with another."""
    data = bytearray(chance.choice(seeds))
    for _ in range(chance.choice((1, 1, 2, 5, 30))):
        place = chance.randrange(len(data) + 1)
        kind = chance.randrange(5)
        if kind == 0 and place < len(data):
            data[place] = chance.randrange(256)
        elif kind == 1:
            del data[place : place + chance.randrange(1, 40)]
        elif kind == 2:
            data[place:place] = data[place : place + chance.randrange(1, 40)]
        elif kind == 3:
            other = chance.choice(seeds)
            start = chance.randrange(len(other) + 1)
            data[place : place + 20] = other[start : start + chance.randrange(1, 60)]
        else:
            data[place:place] = chance.choice(WORDS)
    return bytes(data[:LONGEST])


def fuzz(target: str, seconds: float) -> int:
    """Runs one target; returns the number of findings."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if atheris is not None:
            with atheris.instrument_imports(include=["damper_estimator"], enable_loader_override=False):
                run, seeds = TARGETS[target](folder)
        else:
            run, seeds = TARGETS[target](folder)
        findings = Findings(target, run)
        for seed in seeds:
            findings.take(seed)
        if atheris is None:
            chance, end = random.Random(1), time.monotonic() + seconds
            while time.monotonic() < end:
                findings.take(mutated(seeds, chance))
            return len(findings.kinds)
        corpus = folder / "corpus"
        corpus.mkdir()
        for number, seed in enumerate(seeds):
            (corpus / str(number)).write_bytes(seed)
        words = [sys.argv[0], str(corpus), f"-max_total_time={seconds:g}", f"-max_len={LONGEST}", "-verbosity=0"]
        atheris.Setup([*words, "-timeout=120", "-rss_limit_mb=4096", f"-artifact_prefix={OUT}/"], findings.take)
        atheris.Fuzz()
    return len(findings.kinds)


if __name__ == "__main__":
    logging.disable()
    OUT.mkdir(parents=True, exist_ok=True)
    sys.exit(min(fuzz(sys.argv[1], float(sys.argv[2])), 1))
