"""The launch file of the estimator under the real ``launch``, in a process per launch, with real nodes."""

import pytest
import yaml
from launched import ROOT, drive, killed_and_started_again, refused


def test_the_estimator_is_launched_with_its_arguments(launch, car):
    launch("estimator.launch.py", model="linear_viscous", namespace="car_7", displacement="stroke", log_level="warn",
           safe_current="1")  # fmt: skip
    drive(car, "/car_7/stroke")
    assert (car.get("model"), car.get("max_gap"), car.get("safe_current")) == ("linear_viscous", 0.1, 1.0)


def test_arguments_take_precedence_over_the_users_file(launch, car, tmp_path):
    values = {"model": "coulomb", "autostart": False, "use_sim_time": True, "max_gap": 0.25, "stale_after": 0.5}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    launch("estimator.launch.py", params_file=tmp_path / "mine.yaml", namespace="car_7", use_sim_time="No")
    assert car.state() == "unconfigured"
    assert {name: car.get(name) for name in values} == values | {"use_sim_time": False}


@pytest.mark.parametrize("word, state", [("TRUE", "active"), ("yes", "active"), ("off", "unconfigured")])
def test_autostart_is_read_like_a_boolean_of_ros(word, state, launch, car):
    launch("estimator.launch.py", model="coulomb", namespace="car_7", autostart=word)
    car.wait(lambda: car.health and car.state() == state, f"the state {state}")


@pytest.mark.parametrize(
    "file, arguments, reason",
    [
        ("estimator.launch.py", {"modle": "coulomb"}, "there is no argument modle; did you mean model?"),
        ("estimator.launch.py", {"model": "coulomb", "modell": "dahl"}, "there is no argument modell"),
        ("estimator.launch.py", {"model": "coulomb", "Use-Sim-Time": "true"}, "did you mean use_sim_time?"),
        ("estimator.launch.py", {"model": "coulomb", "colour": "red"}, "there is no argument colour"),
        ("estimator.launch.py", {}, "no model is given"),
        ("estimator.launch.py", {"model": "coulomb", "autostart": "1"}, "autostart must be true or false"),
        ("estimator.launch.py", {"model": "coulomb", "params_file": "/missing.yaml"}, "no such file"),
        ("estimator.launch.py", {"model": "coulomb", "log_level": "loud"}, "log_level must be one of debug"),
        ("semi_active.launch.py", {"model": "coulomb", "damping": "soft"}, "damping must be between 0 and 100000"),
        ("semi_active.launch.py", {"model": "coulomb", "timeout": "nan"}, "timeout must be between"),
        ("semi_active.launch.py", {"model": "coulomb", "law": "sky"}, "law must be one of skyhook"),
        ("semi_active.launch.py", {"model": "coulomb", "autostart": "1"}, "autostart must be true or false"),
        ("semi_active.launch.py", {"model": "coulomb", "tabel": "x.csv"}, "did you mean table?"),
        ("semi_active.launch.py", {"law": "skyhook"}, "no model is given"),
    ],
)
def test_unusable_arguments_are_refused_in_one_line_before_anything_starts(file, arguments, reason, launch):
    assert reason in refused(launch(file, **arguments))


def test_the_shipped_parameter_files_set_no_model(launch):
    for name in ("node.yaml", "controller.yaml"):
        assert "no model is given" in refused(launch("estimator.launch.py", params_file=ROOT / "config" / name))


def test_no_argument_is_a_misspelling_of_another():
    pytest.importorskip("launch_ros.actions")
    from damper_estimator.node.launch_arguments import CONTROLLER, ESTIMATOR, is_misspelt

    names = ESTIMATOR | CONTROLLER
    assert not [(a, b) for a in names for b in names if is_misspelt(a, b)]
    assert not is_misspelt("ros_namespace", "namespace") and not is_misspelt("car", "law")


def test_a_launch_file_that_includes_ours_can_have_further_arguments(launch, car):
    text = """
def generate_launch_description():
    return LaunchDescription([
        DeclareLaunchArgument("models"), DeclareLaunchArgument("colour", default_value="blue"),
        PushRosNamespace("car_7"), SetRemap("suspension/displacement", "stroke"),
        SetParameter("max_gap", 0.25), SetParameter("model", "dahl"),
        ours("estimator.launch.py", model=launch.substitutions.LaunchConfiguration("models")),
    ])
"""
    launch("car.launch.py", text, models="linear_viscous", colour="red")
    drive(car, "/car_7/stroke")
    assert (car.get("model"), car.get("max_gap")) == ("linear_viscous", 0.25)


def test_a_misspelling_in_a_launch_file_that_includes_ours_is_refused(launch):
    text = """
def generate_launch_description():
    return LaunchDescription([ours("estimator.launch.py", modle="coulomb")])
"""
    assert "did you mean model?" in refused(launch("car.launch.py", text))


def test_lifecycle_events_of_a_launch_file_configure_and_activate(launch, car):
    text = """
def changed(transition):
    matcher = matches_node_name("/car_7/damper_estimator")
    return EmitEvent(event=ChangeState(lifecycle_node_matcher=matcher, transition_id=transition))

def generate_launch_description():
    configured = OnStateTransition(
        matcher=lambda event: isinstance(event, StateTransition)
        and (event.start_state, event.goal_state) == ("configuring", "inactive"),
        entities=[changed(3)])
    return LaunchDescription([
        RegisterEventHandler(configured),
        ours("estimator.launch.py", model="coulomb", namespace="car_7", autostart="false"), changed(1),
    ])
"""
    launch("car.launch.py", text)
    car.wait(lambda: car.health and car.state() == "active", "the active state")


def test_a_dead_estimator_does_not_end_the_including_launch_file_and_is_restarted_on_request(launch, car):
    text = """
def generate_launch_description():
    return LaunchDescription([
        launch.actions.ExecuteProcess(cmd=["sleep", "1000"]),
        ours("estimator.launch.py", model="coulomb", namespace="car_7", respawn="true"),
    ])
"""
    process = launch("car.launch.py", text)
    drive(car, "/car_7/suspension/displacement")
    killed_and_started_again("estimator_node", process, car)
    drive(car, "/car_7/suspension/displacement")
    assert process.poll() is None
