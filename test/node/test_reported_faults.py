"""What the node cannot use is reported with its reason, on every topic and for each damper by itself."""

import numpy as np
import rclpy
from test_faults import settle

from damper_estimator.runtime import STALE

SECOND, MS = 10**9, 10**6


def test_samples_of_which_none_can_be_used_are_not_called_a_stop(start, identified, rig):
    start(model=identified("linear_viscous"), dampers="[left]", stale_after=0.2)
    rig.ready()
    settle(rig)
    frozen = rig.stamp

    def reported():
        for _ in range(20):
            rig.send([0.001], stamp=frozen)
            rig.listen(0.005)
        return "messages arrive, but none can be used" in rig.message(": left")

    rig.wait(reported, "the report")
    assert "with equal stamps" in rig.message(": left") and "stopped" not in rig.message(": left")


def test_a_damper_that_stays_silent_after_a_parameter_is_set_is_stale_beside_one_that_goes_on(start, identified, rig):
    start(model=identified("linear_viscous"), dampers="[left, right]", stale_after=0.5)
    rig.ready()
    settle(rig, ["left", "right"])
    last = rig.forces[-1]
    assert rig.set(max_gap=0.3)[0]
    rig.stamp += SECOND
    rig.forces.clear()

    def stale():
        rig.send([0.001], ["left"])
        return any(list(m.name) == ["right"] and list(m.status) == [STALE] for m in rig.forces)

    rig.wait(stale, "STALE of the silent damper")
    old = next(m for m in rig.forces if STALE in m.status)
    assert old.header.stamp == last.header.stamp and old.force[0] == last.force[1]
    assert not any(STALE in m.status and "left" in m.name for m in rig.forces)


def test_samples_that_are_too_rare_for_the_filter_are_reported(start, identified, rig):
    start(model=identified("linear_viscous"), dampers="[left]", stale_after=60.0, cutoff=60.0)
    rig.ready()

    def reported():
        for _ in range(10):
            rig.send([0.02 * np.sin(1e-9 * rig.stamp)], step=50 * MS)
            rig.listen(0.01)
        return "too few for the filter of 60 Hz" in rig.message(": left")

    rig.wait(reported, "the report")
    assert "send 150" in rig.message(": left")


def test_messages_that_do_not_fit_and_publishers_of_other_types_are_reported_on_every_topic(
    start, identified, rig, tmp_path
):
    (tmp_path / "map.yaml").write_text(
        "dampers: {left: {temperature: {topic: /oil}, force: {topic: /gauge, field: 'effort[left]'}}}"
    )
    start(model=identified("linear_viscous"), signals=str(tmp_path / "map.yaml"), dampers="[left]", stale_after=60.0)
    rig.ready()
    rig.publisher("/oil", "sensor_msgs/msg/Temperature")
    rig.wait(lambda: rig.values("input /oil").get("publishers") == "1", "the node to see the publisher")

    def reported():
        rig.send_raw(b"\0\1\0\0\1", "/oil")
        return "do not fit their type" in rig.message("input /oil")

    rig.wait(reported, "the report")
    other = rclpy.create_node("other_gauge")
    try:
        from std_msgs.msg import Float64

        other.create_publisher(Float64, "/gauge", 10)
        rig.wait(lambda: "another type" in rig.message("input /gauge"), "the report")
    finally:
        other.destroy_node()
