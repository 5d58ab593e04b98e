"""One mistake of the measurement chain, in words, with its remedy."""

from dataclasses import asdict, dataclass

from damper_estimator.signals import Channel, DamperSignals

SPOILING = ("dead_channel", "unit", "sign")  # nothing that is identified means anything before they are corrected


@dataclass(frozen=True)
class DataFinding:
    """A mistake that the recordings show by themselves, whatever the model lacks.

    Attributes:
        kind: ``gaps``, ``spikes``, ``stamps``, ``saturation``, ``dead_channel``, ``unit``, ``held``, ``quantisation``,
            ``rate``, ``sign``, ``zero_drift``, ``zero_differs``, ``clock_drift`` or ``spring``.
        sentence: the mistake, with numbers.
        remedy: the action, or the entry of the signal map that corrects it.
        recording: path of the bag; "" for several together.
        share: 0 to 1, of the recording that is affected, or of the force's rms that it causes (drift, spring).
    """

    kind: str
    sentence: str
    remedy: str
    recording: str
    share: float

    @property
    def spoils(self) -> bool:
        """Whether nothing that is identified from the recording means anything before it is corrected."""
        return self.kind in SPOILING

    def record(self) -> dict[str, object]:
        """For JSON."""
        return asdict(self)


def entry(role: str, signals: DamperSignals, **changed: float) -> str:
    """The line of a channel in the signal map with these values changed."""
    channel: Channel = getattr(signals, role)
    values: dict[str, object] = {"topic": channel.topic, "field": f'"{channel.field}"'}
    values |= {} if channel.table is not None else {"scale": channel.scale, "offset": channel.offset}
    values |= {"skew": channel.skew}
    if role == "force":
        values |= {"spring_rate": signals.spring_rate, "preload": signals.preload}
    kept = {key: value for key, value in (values | changed).items() if key in changed or value not in (0.0, None)}
    text = ", ".join(f"{key}: {_text(value)}" for key, value in kept.items() if (key, value) != ("scale", 1.0))
    return f"{role}: {{{text}}}"


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
