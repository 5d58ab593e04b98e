"""The narrow views of a node: rclpy's node has what they declare, and inputs work on nothing more."""

import inspect
from types import SimpleNamespace

import pytest

TOPIC, TYPE = "suspension/displacement", "sensor_msgs/msg/JointState"


@pytest.mark.parametrize("name", ["LoggingNode", "SubscribingNode", "PublishingNode", "NamedNode"])
def test_a_node_of_rclpy_has_what_a_port_declares(name):
    from rclpy.lifecycle import LifecycleNode

    from damper_estimator.node import ports

    for member, declared in inspect.getmembers(getattr(ports, name)):
        if member.startswith("_"):
            continue
        offered = getattr(LifecycleNode, member)
        if inspect.isfunction(declared):
            assert inspect.signature(declared).parameters.keys() <= inspect.signature(offered).parameters.keys(), member


class Node:
    """The part of a node that inputs use; final."""

    def __init__(self) -> None:
        self.receive, self.destroyed = {}, []
        self.context = SimpleNamespace(ok=lambda: True)

    def create_subscription(self, msg_type, topic, callback, qos_profile, **_):
        self.receive[topic] = callback
        return topic

    def destroy_subscription(self, subscription):
        self.destroyed.append(subscription)

    def resolve_topic_name(self, topic):
        return f"/{topic}"

    def get_clock(self):
        return SimpleNamespace(ros_time_is_active=False)


class Estimation:
    """Answers every message with the same bytes; final."""

    topics, displacement = {TOPIC: TYPE}, {}

    def take(self, topic, data, arrival):
        from damper_estimator.node.estimation import Answer

        return Answer(forces=data)


def test_inputs_publish_answers_only_while_the_node_is_active():
    from rclpy.qos import QoSProfile

    from damper_estimator.node.inputs import Inputs
    from damper_estimator.node.ports import NodeState

    node, published = Node(), []
    state = NodeState(estimation=Estimation())
    inputs = Inputs(node, state, published.append, commands=None)
    inputs.open(QoSProfile(depth=1))
    inputs.subscribe(state.estimation)
    for active, data in ((False, b"1"), (True, b"2"), (False, b"3")):
        state.is_active = active
        node.receive[TOPIC](data, {"publication_sequence_number": None, "received_timestamp": 0})
    assert published == [b"2"] and inputs.tallies[TOPIC].messages == 3
    inputs.close()
    assert node.destroyed == [TOPIC] and not inputs.tallies
