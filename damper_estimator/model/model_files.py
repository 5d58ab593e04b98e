"""Model files: YAML in and out, models by name from the installed library."""

import re
from collections.abc import Mapping
from pathlib import Path

import yaml

from damper_estimator import files
from damper_estimator.effects.discovery import LISTS, find_effect
from damper_estimator.errors import InputError, did_you_mean, did_you_mean_file
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.model.element import Element, make_element
from damper_estimator.model.record_faults import REMEDY, record_faults
from damper_estimator.share import share_path

KEYS = ("name", "source", "notes", "effects", "fixed", "fit")
LIBRARY = "config/models"


def library_models() -> dict[str, Path]:
    """Path of every installed model by name, in alphabetical order with numbers in numerical order."""
    paths = share_path(LIBRARY).glob("*.yaml")
    return {path.stem: path for path in sorted(paths, key=lambda path: _numbers_counting(path.stem))}


def _numbers_counting(name: str) -> list[str]:
    return [part.zfill(3) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


def load_model(name_or_path: str | Path, damper: str | None = None) -> DamperModel:
    """Reads a model: a YAML file, a folder with one ``<damper>.yaml`` per damper, or the name of an installed model.

    Raises:
        InputError: one line with the file, the fault and the remedy.
    """
    path = Path(name_or_path)
    if path.is_dir():
        if damper is None or not (path / f"{damper}.yaml").exists():
            found = ", ".join(sorted(p.stem for p in path.glob("*.yaml"))) or "none"
            raise InputError(f"{path}: contains no model for damper {damper}, only for {found}")
        path = path / f"{damper}.yaml"
    elif not path.exists() and path.suffix not in (".yaml", ".yml"):
        library = library_models()
        if str(name_or_path) not in library:
            near = did_you_mean(str(name_or_path), library) or did_you_mean_file(f"{path}.yaml")
            raise InputError(
                f"{name_or_path}: is neither a model file nor a model's name{near or '; choose one'} "
                "(damper-estimator models lists the names)"
            )
        path = library[str(name_or_path)]
    return parse_model(files.read_yaml(path), str(path))


def parse_model(content: object, where: str) -> DamperModel:
    """A model from the content of its file; ``where`` names the file in errors.

    Raises:
        InputError: one line with the file, the fault and the remedy.
    """
    if not isinstance(content, dict) or not isinstance(content.get("effects"), list) or not content["effects"]:
        raise InputError(f"{where}: is not a model file; it needs the keys name, source and a list of effects")
    unknown = [str(key) for key in content if key not in KEYS]
    if unknown:
        raise InputError(f"{where}: unknown keys {', '.join(unknown)}; allowed are {', '.join(KEYS)}")
    try:
        fit, fixed = content.get("fit") or {}, content.get("fixed") or []
        if not isinstance(fixed, list):
            raise InputError("fixed must be a list of addresses")
        if faults := list(record_faults(fit)):
            raise InputError(f"fit: {'; '.join(faults)}; {REMEDY}")
        model = DamperModel(
            name=str(content.get("name", Path(where).stem)),
            source=str(content.get("source", "")),
            effects=_parse_list(content["effects"]),
            fixed=tuple(str(address) for address in fixed),
            notes=str(content.get("notes", "")),
            fit=fit,
        )
        _check_fixed(model)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    return model


def _check_fixed(model: DamperModel) -> None:
    known = {slot.address for slot in model.slots} | {slot.address.split("[")[0] for slot in model.slots}
    unknown = [address for address in model.fixed if address not in known]
    if unknown:
        raise InputError(f"fixed contains {', '.join(unknown)}, which the model does not have")


def _parse_list(entries: object) -> tuple[Element, ...]:
    if not isinstance(entries, list):
        raise InputError(f"expected a list of effects, got {entries!r}")
    return tuple(_parse_entry(entry) for entry in entries)


def _parse_entry(entry: object) -> Element:
    if isinstance(entry, str):
        entry = {entry: {}}
    if not isinstance(entry, dict) or len(entry) != 1:
        raise InputError(f"an effect is written as 'name: {{values}}', got {entry!r}")
    ((name, values),) = entry.items()
    effect = find_effect(str(name))
    if effect.name in LISTS:
        return make_element(effect, path=_parse_list(values))
    if values is not None and not isinstance(values, dict):
        raise InputError(f"effect {name}: its values must be a mapping, got {values!r}")
    values = dict(values or {})
    path = _parse_list(values.pop("path", [])) if effect.kind == "series" else ()
    return make_element(effect, values, path)


def save_model(model: DamperModel, path: str | Path) -> None:
    """Writes a model file atomically.

    Raises:
        InputError: if it cannot be written.
    """
    files.write_text(path, model_yaml(model))


def model_yaml(model: DamperModel) -> str:
    """The model as YAML; ``parse_model`` restores the same model."""
    content: dict[str, object] = {"name": model.name, "source": model.source}
    if model.notes:
        content["notes"] = model.notes
    content["effects"] = [_entry(element) for element in model.effects]
    if model.fixed:
        content["fixed"] = list(model.fixed)
    if model.fit:
        content["fit"] = dict(model.fit)
    return yaml.dump(content, Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)


def _entry(element: Element) -> dict[str, object]:
    if element.effect.name in LISTS:
        return {element.effect.name: [_entry(inner) for inner in element.path]}
    values: Mapping[str, object] = {**element.settings, **element.parameters}
    plain: dict[str, object] = {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}
    if element.path:
        plain["path"] = [_entry(inner) for inner in element.path]
    return {element.effect.name: plain}


class _Dumper(yaml.SafeDumper):
    """Numbers and lists of numbers on one line, floats with all digits and a decimal point."""


def _represent_float(dumper: yaml.SafeDumper, value: float) -> yaml.ScalarNode:
    text = repr(value)
    if "e" in text and "." not in text:
        text = text.replace("e", ".0e")  # YAML 1.1 reads 1e-05 as a string
    text = {"inf": ".inf", "-inf": "-.inf", "nan": ".nan"}.get(text, text)
    return dumper.represent_scalar("tag:yaml.org,2002:float", text)


def _represent_list(dumper: yaml.SafeDumper, value: list) -> yaml.SequenceNode:
    flow = all(isinstance(item, int | float | str) for item in value)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", value, flow_style=flow)


_Dumper.add_representer(float, _represent_float)
_Dumper.add_representer(list, _represent_list)
