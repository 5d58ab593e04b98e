"""The managed node: configure loads and checks, activate publishes; parameters change while it runs, or are refused."""

import time

import numpy as np
import pytest
import yaml

GOOD, STALE = 0, 4
CONFIGURE, CLEANUP, ACTIVATE, DEACTIVATE, SHUTDOWN = 1, 2, 3, 4, 5
FORCE_OF = {"soft": 1000.0, "hard": 3000.0}


@pytest.fixture
def models(tmp_path):
    """Two linear dampers."""
    for name, slope in FORCE_OF.items():
        content = {
            "name": name,
            "source": "test",
            "effects": [{"linear_viscous": {"rebound": slope, "compression": slope}}],
            "fit": {"residual_stddev": 10.0, "region": {"velocity": [-20.0, 20.0]}},
        }
        (tmp_path / f"{name}.yaml").write_text(yaml.safe_dump(content))
    (tmp_path / "broken.yaml").write_text("effects: [{linear_viscous: {rebound: -5.0}}]")
    return {path.stem: str(path) for path in tmp_path.glob("*.yaml")}


def slope(message) -> float:
    """Force over velocity of an estimate."""
    return message.force[0] / message.velocity[0]


def test_each_transition_takes_effect_and_impossible_ones_are_refused(start, rig, models):
    process = start(model=models["broken"], autostart=False)
    assert rig.state() == "unconfigured"
    rig.wait(lambda: rig.status(": node") is not None, "diagnostics")
    assert rig.message(": node") == "not configured"
    assert not rig.transition(ACTIVATE)
    assert not rig.transition(CONFIGURE)
    assert rig.state() == "unconfigured"
    rig.wait(lambda: "rebound" in rig.message(": node"), "the reason in the diagnostics")
    assert rig.set(model=models["soft"]) == (True, "")
    assert rig.transition(CONFIGURE) and rig.state() == "inactive"
    rig.ready()
    while int(rig.fresh_values("input /suspension/displacement")["messages"]) == 0:
        rig.send([0.0])
    assert rig.forces == [] and rig.values("output")["state"] == "inactive"
    assert rig.transition(ACTIVATE) and rig.state() == "active"
    assert slope(rig.drive(50)[-1]) == pytest.approx(FORCE_OF["soft"])
    assert not rig.transition(CONFIGURE) and not rig.transition(99)
    assert rig.state() == "active" and len(rig.drive(5)) == 5
    assert rig.transition(DEACTIVATE) and rig.transition(ACTIVATE)
    assert len(rig.drive(5)) == 5
    assert rig.transition(DEACTIVATE) and rig.transition(CLEANUP) and rig.state() == "unconfigured"
    rig.forget()
    assert rig.set(model=models["hard"]) == (True, "")
    assert rig.transition(CONFIGURE) and rig.transition(ACTIVATE)
    rig.ready()
    assert slope(rig.drive(50)[-1]) == pytest.approx(FORCE_OF["hard"])
    assert rig.transition(DEACTIVATE)
    assert rig.transition(6)  # shutdown of an inactive node
    assert rig.state() == "finalized" and process.poll() is None


def test_a_model_is_exchanged_while_the_node_runs_or_refused_and_the_old_one_stays(start, rig, models, tmp_path):
    start(model=models["soft"], dampers="[left]")
    rig.ready()
    assert slope(rig.drive(50)[-1]) == pytest.approx(FORCE_OF["soft"])
    taken, reason = rig.set(model=models["broken"])
    assert not taken and "broken.yaml" in reason and "rebound" in reason
    assert rig.get("model") == models["soft"] and slope(rig.drive(50)[-1]) == pytest.approx(FORCE_OF["soft"])
    assert rig.set(model=models["hard"]) == (True, "")
    answers = rig.drive(300)
    assert slope(answers[50]) == pytest.approx(FORCE_OF["hard"])
    assert answers[0].status[0] == 1 and answers[-1].status[0] == 0  # warms up once more
    # All of them, or none.
    taken, reason = rig.set(model=models["soft"], signals=str(tmp_path / "missing.yaml"))
    assert not taken and "missing.yaml" in reason and slope(rig.drive(50)[-1]) == pytest.approx(FORCE_OF["hard"])
    (tmp_path / "map.yaml").write_text("dampers: {left: {displacement: {topic: /other, field: 'position[left]'}}}")
    assert rig.set(model=models["soft"], signals=str(tmp_path / "map.yaml")) == (True, "")
    before = len(rig.forces)
    publish = rig.publisher("/other").publish
    from rig import MS, joint_state

    for i in range(60):
        publish(joint_state([0.001 * i], ["left"], rig.stamp + i * MS))
    rig.wait(lambda: len(rig.forces) >= before + 40, "answers on the other topic")
    assert slope(rig.forces[-1]) == pytest.approx(FORCE_OF["soft"])


def test_the_input_is_answered_while_a_model_is_loaded(start, identified, rig):
    """Loading forty dampers takes time, without effect on the answers to the present one."""
    from rcl_interfaces.srv import SetParametersAtomically
    from rclpy.parameter import Parameter

    stale_after = 0.3
    start(model=identified("coulomb"), dampers="[left]", stale_after=stale_after)
    rig.ready()
    client = rig.node.create_client(SetParametersAtomically, f"{rig.name}/set_parameters_atomically")
    rig.wait(client.service_is_ready, "the service")
    rig.drive(260)
    names = ["left", *(f"other_{i}" for i in range(40))]
    changed = {"model": "lozoya_santos_complete", "dampers": names}
    parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in changed.items()]
    before, sent = len(rig.forces), [time.monotonic()]
    future = client.call_async(SetParametersAtomically.Request(parameters=parameters))
    while not future.done():
        rig.send([0.02 * np.sin(0.02 * (259 + len(sent)))])
        sent.append(time.monotonic())
        rig.listen(0.002)
    answers = [message.status[0] for message in rig.forces[before:]]
    assert future.result().result.successful
    assert sent[-1] - sent[0] > stale_after, "the change was too quick to say anything"
    assert len(answers) > 0.8 * len(sent)
    # The old model continues; if the machine halts this test itself for so long, the node is not to blame.
    assert set(answers[: len(answers) // 2]) == {GOOD} or max(np.diff(sent)) > 0.5 * stale_after
    assert STALE not in answers or max(np.diff(sent)) > 0.5 * stale_after


def test_parameters_have_meanings_and_ranges_and_what_is_out_of_range_is_refused(start, rig):
    from rcl_interfaces.srv import DescribeParameters

    from damper_estimator.node.settings import DECLARATIONS

    start(model="coulomb", dampers="[left]")
    rig.ready()
    request = DescribeParameters.Request(names=list(DECLARATIONS))
    descriptors = rig.call(DescribeParameters, "describe_parameters", request).descriptors
    for name, descriptor in zip(DECLARATIONS, descriptors, strict=True):
        assert len(descriptor.description) > 20, name
        ranges = [*descriptor.floating_point_range, *descriptor.integer_range]
        assert len(ranges) == (DECLARATIONS[name].low is not None), name
    for name, value, reason in (
        ("max_gap", -1.0, "max_gap"),
        ("max_gap", float("nan"), "max_gap"),
        ("stale_after", 1e9, "stale_after"),
        ("cutoff", 60, "DOUBLE"),
        ("executor", "single", "executor"),
        ("qos_depth", 7, "configured"),
        ("record", "/tmp", "configured"),
        ("dampers", ["right", "left"], ""),
        ("model", "", "model is not set"),
    ):
        taken, answer = rig.set(**{name: value})
        assert taken == (reason == "") and reason in answer, (name, answer)
    assert len(rig.drive(5, ["left", "right"])) == 5


def test_all_parameters_can_be_dumped_and_a_dump_starts_the_node_again(start, rig, tmp_path):
    """What `ros2 param dump` does: list the names, get the values, write them as YAML."""
    from damper_estimator.node.settings import DECLARATIONS

    process = start(model="coulomb", max_gap=0.25, dampers="[left, right]")
    rig.wait(lambda: rig.health, "the node")
    dumped = rig.dump()
    assert dumped.keys() >= DECLARATIONS.keys() and None not in dumped.values()
    assert rig.set(dampers=[""]) == (True, "")
    dumped = rig.dump()
    assert dumped["dampers"] == [""]
    process.terminate()
    process.wait(60.0)
    path = tmp_path / "damper_estimator.yaml"
    path.write_text(yaml.safe_dump({"/damper_estimator": {"ros__parameters": dumped}}))
    rig.wait(lambda: rig.node.count_publishers("/damper_estimator/force") == 0, "the end of the first node")
    rig.health.clear()
    start("--params-file", str(path))
    rig.wait(lambda: rig.health, "the second node")
    # Overrides of the quality of service belong to the topics of a node.
    assert rig.dump().items() <= dumped.items() and DECLARATIONS.keys() <= rig.dump().keys()


def test_dampers_whose_names_cannot_be_part_of_a_topic_are_estimated(start, rig, tmp_path):
    names = ["front left", "é", "3", "a/b", "~"]
    start(model="coulomb")  # dampers arrive by name
    rig.ready()
    answers = rig.drive(5, names)
    assert list(answers[-1].name) == names
    assert int(rig.fresh_values("input /suspension/displacement")["failures"]) == 0
    assert rig.set(dampers=["é", "front left"]) == (True, "")
    assert list(rig.drive(5, names)[-1].name) == ["é", "front left"]
    (tmp_path / "map.yaml").write_text("dampers: {left: {command: {topic: '/front left/current'}}}")
    taken, reason = rig.set(signals=str(tmp_path / "map.yaml"), dampers=[""])
    assert not taken and "'/front left/current' cannot be a topic" in reason
    assert list(rig.drive(5, names)[-1].name) == ["é", "front left"]


def test_two_nodes_of_two_vehicles_share_nothing(start, rig, models):
    from rig import Rig

    start("-r", "__ns:=/car_1", "-r", "suspension/displacement:=/one", model=models["soft"])
    start("-r", "__ns:=/car_2", model=models["hard"])
    cars = [Rig("/car_1/damper_estimator"), Rig("/car_2/damper_estimator")]
    for car, topic in zip(cars, ("/one", "/car_2/suspension/displacement"), strict=True):
        publisher = car.publisher(topic)
        car.wait(lambda car=car: car.values(f"{car.name[1:]}: output").get("subscribers", "0") != "0", "forces")
        for i in range(50):
            from rig import MS, START, joint_state

            publisher.publish(joint_state([1e-3 * i], ["left"], START + i * MS))
        car.wait(lambda car=car: len(car.forces) >= 50, "answers")
    assert [slope(car.forces[40]) for car in cars] == pytest.approx([FORCE_OF["soft"], FORCE_OF["hard"]])
    for car in cars:
        car.close()


def test_with_simulated_time_the_input_becomes_stale_in_that_time(start, rig):
    from builtin_interfaces.msg import Time
    from rosgraph_msgs.msg import Clock

    start(model="coulomb", dampers="[left]", use_sim_time=True, stale_after=0.2)
    clock = rig.publisher("/clock", "rosgraph_msgs/msg/Clock")
    rig.ready()
    for second in np.arange(5.0, 6.0, 0.1):
        clock.publish(Clock(clock=Time(sec=int(second), nanosec=round(second % 1 * 1e9))))
        rig.listen(0.05)
    rig.drive(3)
    rig.listen(1.0)  # the clock is stopped, so nothing is missing
    assert not [m for m in rig.forces if 4 in m.status]
    for second in (6.0, 6.1, 6.5):
        clock.publish(Clock(clock=Time(sec=int(second), nanosec=round(second % 1 * 1e9))))
    rig.wait(lambda: any(4 in m.status for m in rig.forces), "STALE")
