"""The fleet: throughput of two workers over one, overhead per task, memory over many tasks, load of the scheduler.

    python benchmarks/bench_fleet.py           # a few minutes
    python benchmarks/bench_fleet.py --full    # 2000 recordings of 10 s, 20000 empty tasks, an hour of 1 kHz; 30 min

Limits: two workers at least 1.7 times as fast as one; overhead below 5 % of a task on 60 s; memory flat. Measure on a
quiet machine: workers share its cores with everything else.
"""

import argparse
import os
import pickle
import resource
import subprocess
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryDirectory

import numpy as np
from distributed import Client
from hour_bag import write_hour

from damper_estimator import __version__
from damper_estimator.fleet.cluster import connected
from damper_estimator.fleet.manifest import find_recordings
from damper_estimator.fleet.result_rows import write_rows
from damper_estimator.fleet.scheduling import Fleet, FleetRequest, TaskCounts
from damper_estimator.fleet.task_execution import execute
from damper_estimator.fleet.verbs import Compare, Diagnose, Fit, Replay, work
from damper_estimator.plant import DAMPERS, Sensors, measure, simulate
from damper_estimator.recordings import BagWriter, Stream, joint_states
from damper_estimator.vehicle import drive
from damper_estimator.workflows.simulated_bags import DISPLACEMENT, EPOCH, FORCE

MODEL, RATE, CLUSTER = "carrera_akutain", 500.0, "auto"
SPEED_UP, OVERHEAD = 1.7, 0.05


def write_recordings(folder: Path, count: int, seconds: float) -> None:
    """``count`` recordings of one damper on a road, each with different noise."""
    damper, sensors = DAMPERS["passenger_front"], Sensors(rate=RATE, drop_out=0.0)
    sensed = measure(simulate(damper, drive("road", damper, seconds + 0.5, 3)), sensors, 3, clock_seed=3)
    motion, force = sensed.true_displacement.value, sensed.true_force.value
    size = min(round(seconds * RATE), motion.size, force.size)
    stamp = EPOCH + np.round(np.arange(size) / RATE * 1e9).astype(np.int64)
    for number in range(count):
        draw = np.random.default_rng(number)
        x = motion[:size, None] + sensors.displacement_noise * draw.standard_normal((size, 1))
        f = force[:size, None] + sensors.force_noise * draw.standard_normal((size, 1))
        path = folder / f"car_{number % 20:02}" / f"drive_{number:04}.mcap"
        path.parent.mkdir(parents=True, exist_ok=True)
        with BagWriter(path) as bag:
            bag.write_streams([
                Stream(DISPLACEMENT, "sensor_msgs/msg/JointState", stamp, joint_states(["front"], stamp, position=x)),
                Stream(FORCE, "sensor_msgs/msg/JointState", stamp, joint_states(["front"], stamp, effort=f)),
            ])  # fmt: skip


@dataclass(frozen=True)
class Run:
    """Cost of one run: wall time in s, and the tally with the workers' seconds."""

    seconds: float
    tally: TaskCounts
    fleet: Fleet

    @property
    def rate(self) -> float:
        return self.tally.done / self.seconds


def run(client: Client, folder: Path, output: Path, show_progress=lambda tally: None) -> Run:
    """``fleet compare`` with pages over a folder, from scratch, including the table at its end."""
    rmtree(output, ignore_errors=True)
    recordings = find_recordings([str(folder / "**" / "*.mcap")])
    fleet = Fleet(FleetRequest(Compare(), MODEL, output), recordings, work, show_progress)
    began = time.perf_counter()
    fleet.run(client)
    write_rows(output, "compare", fleet.tasks)
    done = Run(time.perf_counter() - began, fleet.counts, fleet)
    assert fleet.counts.failed == 0 and fleet.counts.done == len(recordings)
    return done


def warmed(client: Client, folder: Path, workers: int) -> None:
    """Lets every worker load and compile its code."""
    (path, *_) = sorted(folder.rglob("*.mcap"))
    for number in range(2):
        futures = [
            client.submit(_warm, str(path), f"{folder}/warm_{number}_{number_of_worker}", workers=address, pure=False)
            for number_of_worker, address in enumerate(client.nthreads())
        ]
        client.gather(futures)
    assert len(client.nthreads()) == workers


def _warm(path: str, folder: str) -> None:
    from damper_estimator.fleet.recording_overview import read_overview
    from damper_estimator.fleet.task import Task

    overview = read_overview(path, "", folder)
    facts = dict.fromkeys(("recording_checksum", "model_checksum", "signals_checksum", "vehicle"), overview.checksum)
    work(Task(Compare(), path, "front", "", MODEL, folder, True, facts))


def throughput(folder: Path, count: int) -> None:
    """Speed-up of two workers on recordings of 60 s, and the overhead of a task."""
    write_recordings(folder / "bags", count, 60.0)
    runs = {}
    for workers in (1, 2):
        with connected(None, workers, CLUSTER) as client:
            warmed(client, folder / "bags", workers)
            runs[workers] = run(client, folder / "bags", folder / "out")
        result = runs[workers]
        print(
            f"{workers} worker(s): {result.rate:.3g} recordings of 60 s a second, "
            f"{1e3 * result.seconds / count:.0f} ms each"
        )
    report(f"two workers over one: {runs[2].rate / runs[1].rate:.2f} x (bar {SPEED_UP})")
    lost = 1.0 - runs[1].tally.seconds / runs[1].seconds
    report(
        f"overhead per task: {100 * lost:.1f} % of {1e3 * runs[1].seconds / count:.0f} ms (bar {100 * OVERHEAD:.0f} %)"
    )


def many(folder: Path, count: int) -> None:
    """Memory of the workers and of this process over many short recordings, and the traffic of each."""
    write_recordings(folder / "bags", count, 10.0)
    seen: list[tuple[int, float]] = []
    with connected(None, 2, CLUSTER) as client:
        warmed(client, folder / "bags", 2)
        before = loopback_bytes()

        def show_progress(tally: TaskCounts) -> None:
            if tally.done % max(count // 40, 1) == 0 and (not seen or seen[-1][0] != tally.done):
                seen.append((tally.done, sum(client.run(resident).values()) + resident()))

        result = run(client, folder / "bags", folder / "out", show_progress)
        travelled = (loopback_bytes() - before) / count
    quarter = max(len(seen) // 4, 1)
    early, late = (float(np.median([mb for _, mb in part])) for part in (seen[quarter : 2 * quarter], seen[-quarter:]))
    report(f"{count} recordings of 10 s: {result.rate:.3g} a second on two workers, {result.tally.failed} failed")
    report(f"resident memory of all processes: {early:.0f} MB in the second quarter, {late:.0f} MB in the last")
    task = result.fleet.tasks[0]
    sent = len(pickle.dumps((execute, task, work, __version__)))
    report(f"a task is {sent} bytes; loopback traffic {travelled / 1e3:.1f} kB per recording, heartbeats included")


def resident() -> float:
    """MB of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def loopback_bytes() -> int:
    """Bytes sent over the loopback device since the machine was started."""
    for line in Path("/proc/net/dev").read_text().splitlines():
        if line.strip().startswith("lo:"):
            return int(line.split(":")[1].split()[8])
    return 0


def scheduler_load(count: int) -> None:
    """Processor time of the scheduler, in a separate process, per task that does nothing."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "scheduler.json"
        dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        scheduler = subprocess.Popen([*dask, "--no-dashboard", "--scheduler-file", str(file)], **quiet)
        worker = subprocess.Popen(
            [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "8",
             "--host", "127.0.0.1", "--no-dashboard", "--local-directory", folder], **quiet,
        )  # fmt: skip
        try:
            with Client(scheduler_file=str(file), timeout=60) as client:
                client.wait_for_workers(1, timeout=60)
                empty(client, 200)
                before, began = processor(scheduler.pid), time.perf_counter()
                empty(client, count)
                worked, seconds = processor(scheduler.pid) - before, time.perf_counter() - began
        finally:
            for process in (worker, scheduler):
                process.terminate()
                process.wait()
    report(
        f"{count} empty tasks: {count / seconds:.0f} a second; the scheduler needs {1e6 * worked / count:.0f} us for "
        f"each, so one scheduler handles at most {count / worked:.0f} tasks a second"
    )


def empty(client: Client, count: int) -> None:
    """Tasks that do nothing, with as many pending as in ``Fleet``."""
    from distributed import as_completed

    begun = 0
    finished = as_completed([client.submit(nothing, k, pure=False) for k in range(min(32, count))])
    for begun, _ in enumerate(finished, min(32, count)):
        if begun < count:
            finished.add(client.submit(nothing, begun, pure=False))


def nothing(number: int) -> int:
    return number


def processor(process: int) -> float:
    """s of processor time of a process so far."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def hour(folder: Path) -> None:
    """Cost of an hour of four dampers at 1 kHz: processor time and memory of each verb's task."""
    path = folder / "bags" / "car" / "hour.mcap"
    path.parent.mkdir(parents=True)
    write_hour(path)
    size = path.stat().st_size / 1e6
    for options in (Compare(), Fit(), Diagnose(), Replay()):
        with connected(None, 1, CLUSTER) as client:
            fleet = Fleet(
                FleetRequest(options, MODEL, folder / "out"),
                [replace(recording, dampers=("front_left",)) for recording in find_recordings([str(path)])],
                work,
                lambda tally: None,
            )
            fleet.run(client)
            (peak,) = client.run(peak_memory).values()
        assert fleet.counts.failed == 0
        written = sum(path.stat().st_size for path in fleet.request.output.rglob(f"*.{options.verb}.*")) / 1e6
        report(
            f"{options.verb} of one damper of an hour at 1 kHz ({size:.0f} MB): {fleet.counts.seconds:.0f} s, "
            f"peak {peak:.0f} MB, {written:.1f} MB written"
        )


def peak_memory() -> float:
    """MB, peak memory of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def report(text: str) -> None:
    print(text, flush=True)


def main() -> None:
    """Prints one line per figure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--full", action="store_true", help="the sizes that the limits refer to")
    full = parser.parse_args().full
    with TemporaryDirectory() as folder:
        throughput(Path(folder) / "speed", 40 if full else 12)
        many(Path(folder) / "many", 2000 if full else 120)
        scheduler_load(20_000 if full else 2000)
        if full:
            hour(Path(folder) / "hour")


if __name__ == "__main__":
    main()
