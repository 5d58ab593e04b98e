"""The parameters of the estimator, each declared once (`parameter`). Independent of ROS."""

from dataclasses import dataclass

from damper_estimator.control.inverse import HORIZON, LEAD
from damper_estimator.node.parameter import CONFIGURING, STARTING, Declaration, declarations_of, parameter

FROM_SIGNAL_MAP = -1.0


@dataclass(frozen=True)
class Settings:
    """The estimator's settings; ``dampers`` is empty for all dampers."""

    model: str = parameter(
        "",
        "model file, folder with one DAMPER.yaml each, or a model's name",
        "The damper's model: a name that `damper-estimator models` lists, a model file (YAML), or a folder with one "
        "<damper>.yaml each. Required: the node refuses to start without a usable model. A published model knows "
        "nothing about your damper: identify your own with `damper-estimator fit`. Setting the parameter again, even "
        "to the same file, reloads the file; the estimates of a new model are WARMING_UP until it has settled (0.2 s "
        "or more).",
    )
    signals: str = parameter(
        "",
        "signal map; '' is the default topics",
        "Signal map (YAML): which topic and field is which quantity, with scale, sign and filter. '' = the default "
        "topics (suspension/displacement and so on), with values in SI units and positive in extension.",
    )
    dampers: tuple[str, ...] = parameter(
        ("",),
        "names of the dampers; [''] is all",
        "Names of the dampers to estimate: [front_left, front_right]. [''] = all dampers of the signal map; without a "
        "map those of the model folder; otherwise every name that arrives. A name that is not in the list is ignored, "
        "one that never arrives is reported.",
    )
    cutoff: float = parameter(
        FROM_SIGNAL_MAP,
        "Hz; 0 is unfiltered, -1 as in the signal map",
        "Hz, cutoff of the third-order low-pass from which velocity and acceleration come. -1.0 = as in the signal map "
        "(60.0 if that gives none), 0.0 = no filter. A lower cutoff gives smoother and later estimates (delay about "
        "1 / (pi cutoff), 5.3 ms at 60 Hz); a model fits best at the cutoff it was identified with, and a difference "
        "is reported.",
        low=-1.0,
        high=1e5,
    )
    max_gap: float = parameter(
        0.1,
        "s, longest continuous step between stamps",
        "s, longest step between two stamps that counts as continuous. A longer one, or a step back by more, resets "
        "filter and model: the status is WARMING_UP until they have settled (0.2 s or more). Set it to a few sample "
        "times of the slowest input you expect.",
        low=1e-6,
        high=3600.0,
    )
    max_age: float = parameter(
        0.5,
        "s after its stamp from which on a sample is too old; 0 judges no age",
        "s, maximum age of a sample on arrival (its stamp against this machine's clock, or /clock): older samples are "
        "DEGRADED. 0.0 judges no age. Stamps that differ by more than a minute belong to another clock and are not "
        "judged.",
        low=0.0,
        high=3600.0,
    )
    compensation: float = parameter(
        0.0,
        "share of the filter's delay that is predicted away",
        "Share of the filter's delay (0.0 to 1.0) that is compensated by prediction with the acceleration. Models are "
        "identified with 0.0; docs/integration.md shows benefit and cost.",
        low=0.0,
        high=1.0,
    )
    stale_after: float = parameter(
        0.1,
        "s without a good sample until STALE is published",
        "s without a good sample of a damper after which its last estimate is published again as STALE, at least 20 "
        "times a second. Set it to a few sample times, and above the pauses of your transport.",
        low=0.005,
        high=3600.0,
    )
    drift_window: float = parameter(
        60.0,
        "s over which the error against the gauge is averaged",
        "s over which the error against the strain gauge is averaged (if suspension/force is received).",
        low=1.0,
        high=3600.0,
    )
    drift_factor: float = parameter(
        2.0,
        "growth of that error that raises the alarm",
        "Growth of that error, as a multiple of its first value, above which /diagnostics warns.",
        low=1.1,
        high=100.0,
    )
    safe_current: float = parameter(
        0.0,
        "commanded without a fresh desired force or a good estimate",
        "Commanded if the desired force is too old or the estimate is not good: the damper's passive setting, in the "
        "unit of the command's messages (A).",
        low=-1e3,
        high=1e3,
        introduction="For dampers whose model has a command: desired forces on ~/desired_force "
        "(sensor_msgs/JointState, name[] and effort[] in N) are answered with currents on "
        "suspension/<damper>/current_command, within the limits that the signal map gives the command "
        "(limits: [low, high]; otherwise those of the model's fit). The next six parameters belong to these commands; "
        "details are in docs/integration.md.",
    )
    desired_force_timeout: float = parameter(
        0.1,
        "s after which a desired force no longer counts",
        "s after which a desired force no longer counts. Set it to a few periods of the controller.",
        low=0.002,
        high=10.0,
    )
    command_extrapolating: bool = parameter(
        False,
        "follow desired forces outside the region of the model's fit as well",
        "Follow desired forces also if the status is EXTRAPOLATING. false commands the safe current outside the region "
        "of the model's fit, which a rough road soon leaves.",
    )
    command_lag: float = parameter(
        0.05,
        "s within which a driver follows its command and reports the current; 0 compares nothing",
        "s within which a driver follows its command and reports the current. The reported current must lie between "
        "the lowest and the highest command of that time, with a tolerance of a tenth of the command range; otherwise "
        "the status is DEGRADED. Set it as short as the driver allows; 0.0 compares nothing.",
        low=0.0,
        high=10.0,
    )
    horizon: float = parameter(
        HORIZON,
        "s ahead at which a command is to have reached the desired force",
        "s ahead at which the desired force is to be reached. A shorter horizon inverts the coil's lag harder: exact "
        "for an exact model, restless for another. About as long as the lag is a good value.",
        low=1e-4,
        high=1.0,
    )
    lead: float = parameter(
        LEAD,
        "s ahead at which the inverse sees the motion",
        "s by which the inverse predicts the motion, to compensate the delay of filter, sensors and driver. Set it "
        "lower with compensation or an accelerometer.",
        low=0.0,
        high=1.0,
    )
    record: str = parameter(
        "",
        "folder for recordings of inputs and estimates; '' is none",
        "Folder for recordings of all inputs and estimates (mcap), '' = none. At most the last half second is lost if "
        "the process is killed; a full disk stops the recording (reported), never the estimates.",
        changes=CONFIGURING,
    )
    record_size: int = parameter(
        256,
        "MB per file of a recording",
        "MB after which a file ends and the next begins.",
        changes=CONFIGURING,
        low=1,
        high=1_000_000,
    )
    record_files: int = parameter(
        0,
        "files of a recording that are kept, oldest go first; 0 is all",
        "Number of files to keep; the oldest are deleted. 0 = all.",
        changes=CONFIGURING,
        low=0,
        high=10**6,
    )
    qos_reliability: str = parameter(
        "best_effort",
        "reliability requested from publishers",
        "'best_effort' receives from every publisher and loses messages under overload; 'reliable' has lost messages "
        "sent again, but does not receive from best-effort publishers (reported in /diagnostics).",
        changes=CONFIGURING,
        allowed=("best_effort", "reliable"),
    )
    qos_depth: int = parameter(
        100,
        "messages that wait while the node is busy",
        "Messages that wait while the node is busy. At 1 kHz 100 messages bridge 0.1 s; more cost memory and, after a "
        "stall, latency.",
        changes=CONFIGURING,
        low=1,
        high=1_000_000,
    )
    executor: str = parameter(
        "events",
        "rclpy executor that delivers the messages",
        "'events' (a third of the load, lower latency) or 'single' (rclpy's default executor). If events are not "
        "available, the node reports it and uses single.",
        changes=STARTING,
        allowed=("events", "single"),
    )
    realtime_priority: int = parameter(
        0,
        "SCHED_FIFO priority of the process; 0 is none",
        "SCHED_FIFO priority (1 to 99) for all threads of the process, 0 = none. If it is not permitted, the node logs "
        "how to permit it and runs without.",
        changes=STARTING,
        low=0,
        high=99,
    )
    autostart: bool = parameter(
        True,
        "configure and activate without a lifecycle manager",
        "Configure and activate at the start. false for a lifecycle manager.",
        changes=STARTING,
    )

    def __post_init__(self) -> None:
        """A parameter file cannot contain an empty list; [''] stands for it."""
        object.__setattr__(self, "dampers", tuple(filter(None, self.dampers)))


DECLARATIONS: dict[str, Declaration] = declarations_of(Settings)
