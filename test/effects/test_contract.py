"""Requirements on every discovered effect: a new effect is tested before its author writes a test."""

import numpy as np
import pytest
import yaml

from damper_estimator.codegen import kernel_source
from damper_estimator.compiled import COMPILED, plain
from damper_estimator.effects.contract import KINDS
from damper_estimator.effects.discovery import all_effects, find_effect
from damper_estimator.errors import InputError
from damper_estimator.model import make_element, parse_model
from damper_estimator.model.damper_model import DamperModel
from damper_estimator.model.model_files import model_yaml
from damper_estimator.model.program import packed
from damper_estimator.signals.layout import COMMAND, DT, PRESSURE, ROWS, TEMPERATURE, A, T, V, X

EFFECTS = all_effects()
PHENOMENA = {
    "gas_spring", "friction", "oil_compressibility", "blow_off", "valve_delay", "cavitation", "temperature_fade",
    "position_dependence", "end_stop", "mount_compliance", "inertia", "asymmetry", "current", "hysteresis",
    "channel_skew", "spring_rate_error", "force_offset", "force_gain_error",
}  # fmt: skip
CHANNEL_PHENOMENA = {"channel_skew", "spring_rate_error", "force_offset", "force_gain_error"}
every_effect = pytest.mark.parametrize("name", EFFECTS)
every_live_effect = pytest.mark.parametrize("name", [n for n, effect in EFFECTS.items() if effect.kind != "channel"])


def block_of(size, seed=0, wild=1.0):
    """A plausible motion on uneven steps; ``wild`` scales it beyond realistic motions."""
    random = np.random.default_rng(seed)
    block = np.empty((ROWS, size))
    block[DT] = random.uniform(0.0005, 0.004, size)
    block[DT, 0] = 0.0
    block[T] = np.cumsum(block[DT])
    omega = 2 * np.pi * 3.0
    block[X] = wild * 0.03 * np.sin(omega * block[T])
    block[V] = wild * 0.03 * omega * np.cos(omega * block[T])
    block[A] = -wild * 0.03 * omega**2 * np.sin(omega * block[T])
    block[COMMAND] = 0.5 + 0.5 * np.sin(block[T])
    block[TEMPERATURE] = 40.0 + block[T]
    block[PRESSURE] = 2e6
    return block


def default_length(effect, parameter):
    return parameter.length({setting.name: setting.default for setting in effect.settings})


def random_values(effect, seed):
    """Values inside the bounds, not at them; near the default where the range is wide."""
    random = np.random.default_rng(seed)
    values = {}
    for parameter in effect.parameters:
        low = max(
            parameter.lower, min(0.3 * parameter.default, 3.0 * parameter.default) - 0.1 * (parameter.default == 0)
        )
        high = min(
            parameter.upper, max(0.3 * parameter.default, 3.0 * parameter.default) + 0.1 * (parameter.default == 0)
        )
        size = default_length(effect, parameter)
        drawn = random.uniform(low, high, size)
        values[parameter.name] = drawn.tolist() if size else float(drawn)
    return values


def model_around(effect, values):
    """The smallest model in which an effect acts."""
    base = make_element(find_effect("linear_viscous"))
    element = make_element(effect, values, (base,) if effect.kind == "series" else ())
    effects = {"input": (element, base), "modifier": (base, element), "channel": (base, element)}.get(
        effect.kind, (element,)
    )
    return DamperModel("contract", "test", effects)


@every_effect
def test_declares_itself_fully(name):
    effect = EFFECTS[name]
    assert effect.kind in KINDS and effect.kind != "path"
    assert effect.phenomenon in PHENOMENA | {""}
    assert (effect.kind == "channel") == (effect.phenomenon in CHANNEL_PHENOMENA)
    assert effect.shows and (effect.separate or not effect.phenomenon)
    assert (effect.order > 0) == (effect.states > 0 or effect.kind == "series")
    for parameter in effect.parameters:
        assert parameter.lower <= parameter.default <= parameter.upper
        assert parameter.lower < parameter.upper and parameter.unit and parameter.meaning
        assert default_length(effect, parameter) in (None, *range(1, 1000))
    for setting in effect.settings:
        assert setting.unit and setting.meaning


@every_effect
def test_documents_its_equation_and_its_source(name):
    description = EFFECTS[name].description
    indented = [line for line in description.splitlines() if line.startswith("    ")]
    assert any("=" in line or "<-" in line for line in indented), "no equation"
    assert "Source:" in description


@every_live_effect
def test_block_stream_and_ragged_splits_agree_bit_for_bit(name):
    effect = EFFECTS[name]
    model, block = model_around(effect, random_values(effect, 1)), block_of(120)
    whole = model.force(block)
    for sizes in ([1] * 120, [7, 1, 40, 2, 70], [119, 1]):
        stream, first, parts = model.stream(), 0, []
        for size in sizes:
            parts.append(stream.force(np.ascontiguousarray(block[:, first : first + size])))
            first += size
        assert np.array_equal(whole, np.concatenate(parts))


@every_effect
@pytest.mark.skipif(not COMPILED, reason="numba is not installed")
def test_compiled_equals_plain_python(name):
    effect = EFFECTS[name]
    element = make_element(
        effect, random_values(effect, 2), (make_element(find_effect("coulomb")),) * (effect.kind == "series")
    )
    parameters = packed(element)
    settings = effect.prepare(element.parameters, element.settings)
    forces, motions = [], []
    for kernel in (effect.kernel, plain(effect.kernel)):
        block, force, state = block_of(80), np.linspace(-500.0, 500.0, 80), np.zeros(effect.states)
        kernel(parameters, settings, block, state, force)
        forces.append(force)
        motions.append(block)
    assert np.allclose(forces[0], forces[1], rtol=1e-12, atol=1e-9)
    assert np.allclose(motions[0], motions[1], rtol=1e-12, atol=1e-12)


@every_live_effect
def test_kernel_can_be_written_in_c(name):
    assert "_kernel(" in kernel_source(EFFECTS[name].kernel)


@every_effect
def test_force_is_finite_at_every_bound_and_for_wild_motion(name):
    effect = EFFECTS[name]
    corners = [{}]
    for parameter in effect.parameters:
        size = default_length(effect, parameter)
        corners += [{parameter.name: [b] * size if size else b} for b in (parameter.lower, parameter.upper)]
    for side in ("lower", "upper"):
        sizes = {p.name: default_length(effect, p) for p in effect.parameters}
        corners.append(
            {
                p.name: [getattr(p, side)] * sizes[p.name] if sizes[p.name] else getattr(p, side)
                for p in effect.parameters
            }
        )
    for values in corners:
        for wild in (0.0, 1.0, 30.0):
            assert np.isfinite(model_around(effect, values).force(block_of(60, wild=wild))).all(), values


@every_effect
def test_model_file_gives_the_same_model_back(name):
    effect = EFFECTS[name]
    model = model_around(effect, random_values(effect, 3))
    again = parse_model(yaml.safe_load(model_yaml(model)), "test")
    assert again == model
    assert np.array_equal(again.force(block_of(40)), model.force(block_of(40)))


@every_effect
def test_declared_linear_parameters_scale_the_effects_force(name):
    """With all others unchanged, the force is homogeneous of degree one in the linear parameters taken together."""
    effect = EFFECTS[name]
    linear = [p.name for p in effect.parameters if p.linear]
    if not linear or effect.kind not in ("source", "channel"):
        return
    values = random_values(effect, 4)
    doubled = {k: (np.multiply(v, 0.5).tolist() if k in linear else v) for k, v in values.items()}
    element, half = make_element(effect, values), make_element(effect, doubled)
    forces = [DamperModel("one", "", (e,)).force(block_of(50)) for e in (element, half)]
    assert np.allclose(forces[0], 2.0 * forces[1], rtol=1e-10, atol=1e-9)


@every_effect
def test_only_input_effects_change_the_motion(name):
    effect = EFFECTS[name]
    block = block_of(50)
    before = block.copy()
    model_around(effect, random_values(effect, 5)).force(block)
    assert np.array_equal(block, before), "the caller's block was changed"


@every_live_effect
def test_late_slow_channels_leave_no_trace(name):
    """The first command, temperature and pressure arrive after the first displacement; the missing ones have no later
    effect."""
    effect = EFFECTS[name]
    base = make_element(find_effect("linear_viscous"))
    element = make_element(effect, random_values(effect, 6), (base,) if effect.kind == "series" else ())
    semi_active = make_element(find_effect("semi_active_squash"))
    effects = {"input": (element, semi_active), "modifier": (base, semi_active, element)}.get(effect.kind, (element,))
    model = DamperModel("late", "test", effects)
    block = block_of(3000)
    late = block.copy()
    late[[COMMAND, TEMPERATURE, PRESSURE], :20] = np.nan
    expected, got = model.force(block), model.force(late)
    assert got[-300:] == pytest.approx(expected[-300:], abs=0.01 * np.abs(expected).max())


@every_effect
def test_unknown_names_and_values_out_of_bounds_are_all_reported_at_once(name):
    effect = EFFECTS[name]
    path = (make_element(find_effect("coulomb")),) * (effect.kind == "series")
    wrong = {"no_such_value": 1.0}
    for parameter in effect.parameters:
        size = default_length(effect, parameter)
        wrong[parameter.name] = [parameter.upper * 2 + 1] * size if size else parameter.upper * 2 + 1
    with pytest.raises(InputError) as caught:
        make_element(effect, wrong, path)
    for fault in wrong:
        assert fault in str(caught.value)
