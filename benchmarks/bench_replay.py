"""Time and memory of a replay of a long recording, compared with the mcap library reading and writing as many raw
messages.

    python benchmarks/bench_replay.py          # 10 minutes against 3
    python benchmarks/bench_replay.py --full   # an hour against 10 minutes, as the limits require

Four dampers in one message at 1 kHz. Both run one after the other in separate processes, on the same file.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from hour_bag import write_hour

MODEL, DAMPERS = "carrera_akutain", 4
SHARE, MEMORY = 2.5, 500.0

RAW = """
import sys
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

source, target, times = sys.argv[1], sys.argv[2], float(sys.argv[3])
with open(source, "rb") as file, open(target, "wb") as out:
    writer, channels, owed = Writer(out, compression=CompressionType.ZSTD), {}, 0.0
    writer.start(profile="ros2", library="raw")
    for schema, channel, message in make_reader(file).iter_messages():
        if channel.id not in channels:
            own = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, own)
        owed += times
        while owed >= 1.0:
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
            owed -= 1.0
    writer.finish()
"""


def timed(words: list[str]) -> tuple[float, float]:
    """Wall time in s and peak memory in MB of a process."""
    watch = (
        "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL);"
        "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3)"
    )
    began = time.perf_counter()
    done = subprocess.run([sys.executable, "-c", watch, *words], check=True, capture_output=True, text=True)
    return time.perf_counter() - began, float(done.stdout.split()[-1])


def messages(path: Path) -> int:
    """Number of messages of a recording."""
    from damper_estimator.recordings import open_bag

    with open_bag(path) as bag:
        return sum(topic.messages for topic in bag.topics)


def replayed(bag: Path, out: Path) -> tuple[float, float]:
    """Wall time and memory of the verb."""
    return timed([sys.executable, "-m", "damper_estimator", "replay", str(bag), "-m", MODEL, "-o", str(out)])


def compare(folder: Path, seconds: float, shorter: float) -> None:
    """Prints both times, their ratio, and the memory for both lengths."""
    long, short, out, raw = (folder / f"{name}.mcap" for name in ("long", "short", "out", "raw"))
    write_hour(short, shorter)
    replayed(short, out)  # compiles
    _, little = replayed(short, out)
    write_hour(long, seconds)
    took, memory = replayed(long, out)
    times = messages(out) / messages(long)
    alone, _ = timed([sys.executable, "-c", RAW, str(long), str(raw), repr(times)])
    share = took / alone
    what = f"{messages(long)} messages of {DAMPERS} dampers, {seconds / 60.0:g} min at 1 kHz"
    print(f"{what}: {alone:.0f} s to read them raw and write {messages(raw)} with the mcap library alone")
    print(f"  replay: {took:.0f} s, {share:.2f} x (bar {SHARE:g}{'' if share <= SHARE else ', MISSED'})")
    verdict = "" if memory <= MEMORY else ", MISSED"
    print(f"  memory at most {memory:.0f} MB (bar {MEMORY:.0f}{verdict}), of {shorter / 60.0:g} min {little:.0f} MB")


def main() -> None:
    """Measures the time of one length and the memory of two."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--full", action="store_true", help="an hour against ten minutes")
    seconds, shorter = (3600.0, 600.0) if parser.parse_args().full else (600.0, 180.0)
    with TemporaryDirectory() as folder:
        compare(Path(folder), seconds, shorter)


if __name__ == "__main__":
    main()
