"""The node ``damper_estimator``: a managed node with displacement in, damper forces out, health once a second."""

import time
import traceback
from collections.abc import Callable

from damper_msgs.msg import DamperForces
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.lifecycle import LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from damper_estimator.errors import InputError
from damper_estimator.node.commanding import Commanding
from damper_estimator.node.estimation import Estimation
from damper_estimator.node.inputs import Inputs
from damper_estimator.node.meanwhile import meanwhile
from damper_estimator.node.process import collect_garbage, tame_garbage_collector
from damper_estimator.node.quality import OVERRIDABLE
from damper_estimator.node.rclpy_private import RefusingLifecycleNode
from damper_estimator.node.recorder import Recorder
from damper_estimator.node.report import Reporter
from damper_estimator.node.roster import make_roster
from damper_estimator.node.settings import CONFIGURING, DECLARATIONS, declare, read_settings

HEALTH_PERIOD = 1.0  # s, REP-107
COMPARE_PERIOD = 0.05  # s
LONGEST_WATCH = 0.05  # s between two looks for inputs that have stopped
OUTPUT_DEPTH = 100
# Changes of these leave filters and models as they are.
LIGHT = {"max_age", "stale_after", "drift_window", "drift_factor", "safe_current", "desired_force_timeout"}
DONE, REFUSED = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE
FAILED = TransitionCallbackReturn.ERROR


class EstimatorNode(RefusingLifecycleNode):
    """Runs filter and model of every damper at the rate of the input; final.

    Publishes one ``DamperForces`` per displacement message, with its header, for those dampers whose sample was good,
    and currents for those dampers for which forces are desired.
    *Configured* is: everything loaded, checked and subscribed; *active* is: publishing.

    Attributes:
        refusal: why the last transition to configured was refused, in one line.
    """

    def __init__(self) -> None:
        """Raises InputError where a parameter has the wrong type or is out of its range."""
        super().__init__("damper_estimator")
        declare(self)
        self.refusal = ""
        self.is_active = False
        self.estimation: Estimation | None = None
        self.recorder: Recorder | None = None
        self.inputs = Inputs(self)
        self.commanding = Commanding(self, self._keep)
        self._candidate: Estimation | None = None
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._configured: list = []  # timers and publishers that go with the configuration
        self._watched = self._patient_until = 0.0
        self._reporter = Reporter(self)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", OUTPUT_DEPTH)
        self.add_on_set_parameters_callback(self._check_parameters)
        self.add_post_set_parameters_callback(self._take_parameters)
        # A simulated clock may stand still; health is told all the same.
        self.create_timer(HEALTH_PERIOD, self._guarded(self._tell_health), clock=self._steady)

    def start(self) -> None:
        """Configures and activates.

        Raises:
            InputError: one line, where parameters, signal map or a model are unusable.
        """
        for transition in (self.trigger_configure, self.trigger_activate):
            if transition() != DONE:
                raise InputError(self.refusal or "the node could not be started; the log has the reason")

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
            if self.recorder is not None:
                self.recorder.start()
            self.is_active = True

        return self._transition(activate)

    def on_deactivate(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Stops to publish; what is loaded stays."""
        return self._transition(self._pause)

    def on_cleanup(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Forgets what is loaded."""
        return self._transition(self._forget)

    def on_shutdown(self, _: LifecycleState) -> TransitionCallbackReturn:
        """Ends recording and publishing, from any state."""
        return self._transition(self._forget)

    def on_error(self, _: LifecycleState) -> TransitionCallbackReturn:
        """After a failure of our own: back to the beginning."""
        return self._transition(self._forget)

    def _transition(self, act: Callable[[], None]) -> TransitionCallbackReturn:
        try:
            act()
        except InputError as error:
            self.refusal = str(error)
            self.get_logger().error(f"refused: {error}")
            return REFUSED
        except Exception:
            if not self.context.ok():
                raise
            self.get_logger().error(traceback.format_exc())
            return FAILED
        self.refusal = ""
        return DONE

    def _configure(self) -> None:
        settings = read_settings(self)
        estimation = Estimation(settings, make_roster(settings))
        self.inputs.check(estimation)
        recorder = Recorder(settings.record, settings.record_size, settings.record_files) if settings.record else None
        quality = QoSProfile(depth=settings.qos_depth, reliability=ReliabilityPolicy[settings.qos_reliability.upper()])
        events = PublisherEventCallbacks(incompatible_qos=self._reporter.note_incompatible_output)
        self.forces = self.create_publisher(
            DamperForces, "~/force", OUTPUT_DEPTH, event_callbacks=events, qos_overriding_options=OVERRIDABLE
        )
        self.residuals = self.create_publisher(
            JointState, "~/residual", OUTPUT_DEPTH, qos_overriding_options=OVERRIDABLE
        )
        self.commanding.open()
        self._configured = [
            self.create_timer(COMPARE_PERIOD, self._guarded(self._compare), clock=self._steady),
            self.forces,
            self.residuals,
        ]
        self.recorder = recorder
        self.inputs.open(quality)
        self._use(estimation)

    def _use(self, estimation: Estimation) -> None:
        """From the next message on."""
        if self.is_active and estimation.roster is not self.estimation.roster:
            self.commanding.publish(self.estimation.safe())  # the new one begins without desired forces
        self.estimation = estimation
        self.inputs.look_at_clock()
        self._watch_every(min(0.5 * estimation.settings.stale_after, LONGEST_WATCH))
        self.inputs.subscribe(estimation)
        self.commanding.offer(estimation.commanded)
        self._reporter.introduce(estimation)

    def _watch_every(self, period: float) -> None:
        for timer in self._configured[3:]:
            self.destroy_timer(timer)
        self._watch_period = period
        self._configured[3:] = [self.create_timer(period, self._guarded(self._watch), clock=self._steady)]

    def _pause(self) -> None:
        """What is commanded is left at the safe current."""
        if self.is_active and self.context.ok():
            self.commanding.publish(self.estimation.safe())
        self.is_active = False
        if self.recorder is not None:
            self.recorder.stop()

    def _forget(self) -> None:
        self._pause()
        self.inputs.close()
        self.commanding.close()
        for entity in self._configured:
            (self.destroy_publisher if isinstance(entity, Publisher) else self.destroy_timer)(entity)
        self._configured, self.estimation, self.recorder = [], None, None

    def end(self) -> None:
        """Leaves the dampers at the safe current and closes the recording, also where the context was shut down."""
        last = self.estimation.safe() if self.is_active and not self.context.ok() else []
        self._pause()
        self.commanding.settle(last)

    def _check_parameters(self, parameters: list[Parameter]) -> SetParametersResult:
        """Loads what the parameters ask for; nothing changes yet."""
        self._candidate = None
        own = [parameter for parameter in parameters if parameter.name in DECLARATIONS]
        try:
            self._candidate = self._prepared({p.name: p.value for p in own}) if own else None
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
        if self.estimation is None:
            return None
        fixed = [name for name in changed if DECLARATIONS[name].changes == CONFIGURING]
        if fixed:
            raise InputError(
                f"parameter {', '.join(fixed)} is read when the node is configured; deactivate and clean up first"
            )
        settings = read_settings(self, changed)
        if changed.keys() <= LIGHT:
            return self.estimation.changed(settings)
        estimation = meanwhile(lambda: Estimation(settings, make_roster(settings)), self._serve)
        self.inputs.check(estimation)
        return estimation

    def _serve(self) -> bool:
        """What the executor would do now: messages and the look for inputs that have stopped."""
        if time.monotonic() - self._watched >= self._watch_period:
            self._watch()
        return self.inputs.take_waiting()

    def _take_parameters(self, _: list[Parameter]) -> None:
        if self._candidate is not None:
            self._use(self._candidate)
            self._candidate = None

    def _watch(self) -> None:
        """Looks for inputs that have stopped. After a stall of our own messages have as long to come as ever."""
        steady = time.monotonic()
        if steady - self._watched > 4.0 * self._watch_period:
            self._patient_until = steady + self.estimation.settings.stale_after
        self._watched = steady
        if not self.is_active or steady < self._patient_until:
            return
        now = self.inputs.now()
        for message in self.estimation.stale(now):
            self.publish_forces(message)
        self.commanding.publish(self.estimation.overdue(now, 0.5 * self._watch_period))
        self.commanding.state(self.estimation.idle())

    def publish_forces(self, message: bytes) -> None:
        """Publishes and records serialised forces."""
        self.forces.publish(message)
        self._reporter.published += 1
        self._keep(self.forces, "damper_msgs/msg/DamperForces", message)

    def _keep(self, publisher: Publisher, type_name: str, message: bytes) -> None:
        if self.recorder is not None:
            self.recorder.keep(publisher.topic_name, type_name, message)

    def _compare(self) -> None:
        if not self.is_active:
            return
        messages = self.estimation.compare()
        if self.residuals.get_subscription_count() or self.recorder is not None:
            for message in messages:
                self.residuals.publish(message)
                self._keep(self.residuals, "sensor_msgs/msg/JointState", message)

    def _tell_health(self) -> None:
        self.inputs.look_at_clock()
        message = DiagnosticArray(status=self._reporter.statuses())
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)
        collect_garbage()

    def _guarded(self, act: Callable[[], None]) -> Callable[[], None]:
        """A timer's callback that logs a failure of our own and goes on."""

        def run() -> None:
            try:
                act()
            except Exception:
                if self.context.ok():
                    self.get_logger().error(traceback.format_exc(), throttle_duration_sec=HEALTH_PERIOD)

        return run
