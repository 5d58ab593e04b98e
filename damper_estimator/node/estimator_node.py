"""The node ``damper_estimator``: a managed node with displacement in, damper forces out, health once a second."""

import time
import traceback
from collections.abc import Callable

from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.timer import Timer
from sensor_msgs.msg import JointState

from damper_estimator.errors import InputError
from damper_estimator.node.background import in_background
from damper_estimator.node.command_publisher import CommandPublisher
from damper_estimator.node.estimation import Estimation
from damper_estimator.node.force_publisher import ForcePublisher
from damper_estimator.node.inputs import Inputs
from damper_estimator.node.parameter import CONFIGURING
from damper_estimator.node.ports import NodeState
from damper_estimator.node.process import collect_garbage, tame_garbage_collector
from damper_estimator.node.quality_of_service import OVERRIDABLE
from damper_estimator.node.rclpy_private import RefusingLifecycleNode
from damper_estimator.node.recorder import Recorder
from damper_estimator.node.reporter import Reporter
from damper_estimator.node.residuals import CAPACITY
from damper_estimator.node.ros_parameters import declare, read_settings
from damper_estimator.node.roster import make_roster
from damper_estimator.node.settings import DECLARATIONS

HEALTH_PERIOD = 1.0  # s, REP-107
COMPARE_PERIOD = 0.05  # s
LONGEST_WATCH = 0.05  # s between two checks for inputs that have stopped
OUTPUT_DEPTH = 100
# Changes of these leave filters and models unchanged.
LIGHT = {"max_age", "stale_after", "drift_window", "drift_factor", "safe_current", "desired_force_timeout"}
DONE, REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
FAILED = TransitionCallbackReturn.ERROR


class EstimatorNode(RefusingLifecycleNode):
    """Runs filter and model of every damper at the rate of the input; final.

    Publishes one ``DamperForces`` per displacement message, with its header, for those dampers whose sample was good,
    and currents for those dampers for which forces are desired.
    *Configured*: everything is loaded, checked and subscribed; *active*: the node publishes.

    Attributes:
        state: the present state, to be read only.
    """

    def __init__(self) -> None:
        """Raises InputError if a parameter has the wrong type or is out of its range."""
        super().__init__("damper_estimator")
        declare(self, DECLARATIONS)
        self.state = NodeState()
        self._forces = ForcePublisher(self, self._keep)
        self._commands = CommandPublisher(self, self._keep)
        self._inputs = Inputs(self, self.state, self._forces.publish, self._commands)
        self._reporter = Reporter(self, self.state, self._inputs, self._forces)
        self._residuals: Publisher | None = None
        self._candidate: Estimation | None = None
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._configured_timers: list[Timer] = []  # of the configuration; the second one watches the inputs
        self._watched = self._patient_until = 0.0
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", OUTPUT_DEPTH)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        # A simulated clock can be stopped; health is published all the same.
        self.create_timer(HEALTH_PERIOD, self._guarded(self._publish_health), clock=self._steady)

    def start(self) -> None:
        """Configures and activates.

        Raises:
            InputError: one line, if parameters, signal map or a model are unusable.
        """
        for transition in (self.trigger_configure, self.trigger_activate):
            if transition() != DONE:
                raise InputError(self.state.refusal or "the node could not be started; the log has the reason")

    def on_configure(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Loads, checks and compiles everything; refuses with a line in the log."""
        self.get_logger().info(
            "loading the models; the first start of a version compiles them, which takes some seconds"
        )
        return self._transition(self._configure)

    def on_activate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Begins to publish."""

        def activate() -> None:
            tame_garbage_collector()
            self._watched = time.monotonic()
            if self.state.recorder is not None:
                self.state.recorder.start()
            self.state.is_active = True

        return self._transition(activate)

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Stops publishing; everything stays loaded."""
        return self._transition(self._pause)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Unloads everything."""
        return self._transition(self._forget)

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Ends recording and publishing, from any state."""
        return self._transition(self._forget)

    def on_error(self, _: LifecycleState) -> TransitionCallbackReturn:
        """After an internal error: unloads everything."""
        return self._transition(self._forget)

    def _transition(self, act: Callable[[], None]) -> TransitionCallbackReturn:
        try:
            act()
        except InputError as error:
            self.state.refusal = str(error)
            self.get_logger().error(f"refused: {error}")
            return REFUSED
        except Exception:
            if not self.context.ok():
                raise
            self.get_logger().error(traceback.format_exc())
            return FAILED
        self.state.refusal = ""
        return DONE

    def _configure(self) -> None:
        settings = read_settings(self)
        estimation = Estimation(settings, make_roster(settings))
        self._inputs.check(estimation)
        recorder = Recorder(settings.record, settings.record_size, settings.record_files) if settings.record else None
        quality = QoSProfile(depth=settings.qos_depth, reliability=ReliabilityPolicy[settings.qos_reliability.upper()])
        self._forces.open()
        self._residuals = self.create_publisher(
            JointState, "~/residual", CAPACITY, qos_overriding_options=OVERRIDABLE
        )  # one comparison publishes all its residuals at once
        self._commands.open()
        self._configured_timers = [self.create_timer(COMPARE_PERIOD, self._guarded(self._compare), clock=self._steady)]
        self.state.recorder = recorder
        self._inputs.open(quality)
        self._use(estimation)

    def _use(self, estimation: Estimation) -> None:
        """Answers further messages with this estimation."""
        state = self.state
        if state.is_active and estimation.roster is not state.estimation.roster:
            self._commands.publish(state.estimation.safe())  # the new one begins without desired forces
        estimation.continue_after(state.estimation)
        state.estimation = estimation
        self._inputs.check_clock()
        self._watch_every(min(0.5 * estimation.settings.stale_after, LONGEST_WATCH))
        self._inputs.subscribe(estimation)
        self._commands.offer(estimation.commanded)
        self._reporter.introduce(estimation)

    def _watch_every(self, period: float) -> None:
        for timer in self._configured_timers[1:]:
            self.destroy_timer(timer)
        self._watch_period = period
        self._configured_timers[1:] = [self.create_timer(period, self._guarded(self._watch), clock=self._steady)]

    def _pause(self) -> None:
        """Stops publishing, with every commanded damper at its safe current."""
        state = self.state
        if state.is_active and self.context.ok():
            self._commands.publish(state.estimation.safe())
        state.is_active = False
        if state.recorder is not None:
            state.recorder.stop()

    def _forget(self) -> None:
        self._pause()
        self._inputs.close()
        self._commands.close()
        for timer in self._configured_timers:
            self.destroy_timer(timer)
        self._forces.close()
        if self._residuals is not None:
            self.destroy_publisher(self._residuals)
        self._configured_timers, self._residuals = [], None
        self.state.estimation = self.state.recorder = None

    def end(self) -> None:
        """Leaves the dampers at the safe current and closes the recording, even if the context was shut down."""
        last = self.state.estimation.safe() if self.state.is_active and not self.context.ok() else []
        self._pause()
        self._commands.deliver(last)

    def _check_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Prepares the estimation for the changed parameters; nothing changes yet."""
        self._candidate = None
        changed = {parameter.name: parameter.value for parameter in parameters if parameter.name in DECLARATIONS}
        try:
            self._candidate = self._prepared(changed) if changed else None
        except InputError as error:
            return SetParametersResult(successful=False, reason=str(error))
        except Exception as error:
            self.get_logger().error(traceback.format_exc())
            return SetParametersResult(
                successful=False, reason=f"internal error ({error!r}); the log has the traceback"
            )
        return SetParametersResult(successful=True)

    def _prepared(self, changed: dict[str, object]) -> Estimation | None:
        deleted = [name for name, value in changed.items() if value is None]
        if deleted:
            raise InputError(f"parameter {', '.join(deleted)} cannot be deleted")
        if self.state.estimation is None:
            return None
        fixed = [name for name in changed if DECLARATIONS[name].changes == CONFIGURING]
        if fixed:
            raise InputError(
                f"parameter {', '.join(fixed)} is read when the node is configured; deactivate and clean up first"
            )
        settings = read_settings(self, changed)
        if changed.keys() <= LIGHT:
            return self.state.estimation.changed(settings)
        estimation = in_background(lambda: Estimation(settings, make_roster(settings)), self._serve)
        self._inputs.check(estimation)
        return estimation

    def _serve(self) -> bool:
        """Does the executor's work: answers messages and checks for inputs that have stopped."""
        if time.monotonic() - self._watched >= self._watch_period:
            self._watch()
        return self._inputs.take_waiting()

    def _take_parameters(self, _: list[Parameter]) -> None:
        if self._candidate is not None:
            self._use(self._candidate)
            self._candidate = None

    def _watch(self) -> None:
        """Checks for inputs that have stopped. After a stall of this process, messages get the usual time to come."""
        estimation, steady = self.state.estimation, time.monotonic()
        if steady - self._watched > 4.0 * self._watch_period:
            self._patient_until = steady + estimation.settings.stale_after
        self._watched = steady
        if not self.state.is_active or steady < self._patient_until:
            return
        now = self._inputs.now()
        self._commands.publish(estimation.overdue(now, 0.5 * self._watch_period))  # first: the safe currents
        for message in estimation.stale(now):
            self._forces.publish(message)
        self._commands.report(estimation.idle())

    def _keep(self, publisher: Publisher, type_name: str, message: bytes) -> None:
        if self.state.recorder is not None:
            self.state.recorder.keep(publisher.topic_name, type_name, message)

    def _compare(self) -> None:
        if not self.state.is_active:
            return
        messages = self.state.estimation.compare()
        if self._residuals.get_subscription_count() or self.state.recorder is not None:
            for message in messages:
                self._residuals.publish(message)
                self._keep(self._residuals, "sensor_msgs/msg/JointState", message)

    def _publish_health(self) -> None:
        self._inputs.check_clock()
        message = DiagnosticArray(status=self._reporter.statuses())
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)
        collect_garbage()

    def _guarded(self, act: Callable[[], None]) -> Callable[[], None]:
        """A timer's callback that logs an internal error and continues."""

        def run() -> None:
            try:
                act()
            except Exception:
                if self.context.ok():
                    self.get_logger().error(traceback.format_exc(), throttle_duration_sec=HEALTH_PERIOD)

        return run
