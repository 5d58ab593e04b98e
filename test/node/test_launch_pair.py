"""Estimator and controller launched together, under the real ``launch``."""

import os
import signal
import time

import numpy as np
import pytest
import yaml
from launched import ENDED_WITHIN, drive, group_of, killed_and_started_again, process_of
from rig import Rig
from semi_active import DAMPERS, SAFE, Car, by_table, semi_active_parameters

from damper_estimator.recordings import accelerations


@pytest.mark.parametrize("with_table", [False, True])
def test_estimator_and_controller_are_launched_together_and_command_currents(with_table, launch, car, tmp_path):
    parameters = semi_active_parameters(tmp_path)
    if with_table:
        parameters["table"] = by_table(tmp_path)
    shared = {name: parameters.pop(name) for name in ("stale_after", "safe_current", "command_lag")}
    content = {"/**": {"ros__parameters": shared},
               "/**/damper_controller": {"ros__parameters": {"timeout": 5.0}}}  # fmt: skip
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(content))
    parameters = {name: parameters[name] for name in ("model", "signals", "table") if name in parameters} | {
        "law": "skyhook",
        "damping": 2000,
    }
    process = launch("semi_active.launch.py", params_file=tmp_path / "mine.yaml", namespace="car_7", **parameters)
    both = Car(car, DAMPERS, "/car_7")
    felt = [car.publisher_unmatched(both.topic(name, "body_acceleration"), "geometry_msgs/msg/AccelStamped")
            for name in DAMPERS]  # fmt: skip

    def is_controlled() -> bool:
        upwards = np.array([10.0 * np.sin(0.01 * len(car.forces))])
        for publisher in felt:
            publisher.publish(accelerations(np.array([car.stamp]), upwards)[0])
        return all(len(set(commands)) > 5 and commands[-1] != SAFE for commands in both.commands.values())

    both.drive_until(is_controlled, "currents", desired=None)
    assert all(0.0 <= command <= 2.0 for commands in both.commands.values() for command in commands)
    controller = Rig("/car_7/damper_controller")
    assert [controller.get(name) for name in ("timeout", "safe_current", "damping")] == [5.0, SAFE, 2000.0]
    controller.close()
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=ENDED_WITHIN)[0]
    car.listen(0.3)
    assert both.last() == dict.fromkeys(DAMPERS, SAFE)
    assert process.returncode == 0 and said.count("finished cleanly") == 2 and "Caught exception" not in said, said


@pytest.mark.parametrize("executable", ["estimator_node", "controller_node"])
def test_the_end_of_either_node_ends_the_launch_of_both(executable, launch, car):
    process = launch("semi_active.launch.py", model="coulomb", namespace="car_7")
    drive(car, "/car_7/suspension/displacement")
    car.wait(lambda: process_of("controller_node", process) is not None, "the controller")
    os.kill(process_of(executable, process), signal.SIGKILL)
    said = process.communicate(timeout=ENDED_WITHIN)[0]
    assert "shutting down launched system" in said and "Caught exception" not in said
    assert group_of(process) == []


def test_both_nodes_are_restarted_on_request(launch, car):
    process = launch("semi_active.launch.py", model="coulomb", namespace="car_7", respawn="true")
    for executable in ("estimator_node", "controller_node"):
        drive(car, "/car_7/suspension/displacement")
        killed_and_started_again(executable, process, car)
    assert process.poll() is None


def test_a_signal_while_both_nodes_start_leaves_nothing_behind(launch):
    process = launch("semi_active.launch.py", model="coulomb")
    time.sleep(2.0)  # the nodes are starting
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=ENDED_WITHIN)
    assert process.returncode == 0 and group_of(process) == []
