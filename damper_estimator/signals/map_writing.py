"""Signal maps as files."""

from dataclasses import asdict
from pathlib import Path

import numpy as np
import yaml

from damper_estimator import files
from damper_estimator.signals.signal_map import DamperSignals, SignalMap


def signal_map_yaml(signal_map: SignalMap) -> str:
    """The map as YAML; ``parse_signal_map`` returns the same map. Channels that were not named are left out."""
    content: dict[str, object] = {
        "filter": {"cutoff": signal_map.cutoff or "none", "band": signal_map.band or "none"},
        "dampers": {name: _damper_content(signals) for name, signals in signal_map.dampers.items()},
    }
    if signal_map.fusion is not None:
        content["filter"]["fusion"] = asdict(signal_map.fusion)
    if signal_map.windows:
        content["use"] = [
            {"from": start} | ({"to": end} if np.isfinite(end) else {}) for start, end in signal_map.windows
        ]
    return yaml.safe_dump(content, sort_keys=False, allow_unicode=True, default_flow_style=None, width=140)


def _damper_content(signals: DamperSignals) -> dict[str, object]:
    content: dict[str, object] = {}
    for role, channel in signals.channels().items():
        if not channel.given:
            continue
        entry = {key: value for key, value in asdict(channel).items() if key != "given" and value not in ("", None)}
        if channel.limits is not None:
            entry["limits"] = list(channel.limits)
        if channel.table is not None:
            entry = {k: v for k, v in entry.items() if k not in ("scale", "offset")}
            entry["table"] = {"raw": list(channel.table[0]), "value": list(channel.table[1])}
        if role == "force":
            entry |= {"spring_rate": signals.spring_rate, "preload": signals.preload}
        content[role] = entry
    return content


def save_signal_map(signal_map: SignalMap, path: str | Path) -> None:
    """Writes a map in one step.

    Raises:
        InputError: if it cannot be written.
    """
    files.write_text(path, signal_map_yaml(signal_map))
