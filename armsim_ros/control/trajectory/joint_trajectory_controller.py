# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
The joint trajectory controller.

New trajectories, cancels and changes of pace come from any thread through a mailbox that the
control loop empties at the start of its update; until then a goal is pending and nothing that
happens to the old trajectory touches it. Goals end in the control loop's thread. The state is
read through :meth:`JointTrajectoryController.snapshot` from any thread.
"""

from __future__ import annotations

from collections.abc import Sequence
import math
from typing import ClassVar

from armsim_ros.config.base import Settings
from armsim_ros.config.controllers.joint_trajectory_controller import (
    JointTrajectoryControllerParameters,
    PassthroughTrajectoryControllerParameters,
    ScaledJointTrajectoryControllerParameters,
)
from armsim_ros.control.controller import Controller, Rate
from armsim_ros.control.hardware_interface import JointProperties
from armsim_ros.control.mailbox import GoalStatus, RepeatedWarning
from armsim_ros.control.trajectory.controller_state import (
    ControllerSnapshot,
    query,
    QueryResult,
    snapshot_of,
)
from armsim_ros.control.trajectory.goal import (
    CancelRequest,
    GoalResponse,
    RefusedTrajectoryError,
    TrajectoryGoal,
    TrajectoryResult,
)
from armsim_ros.control.trajectory.intake import TrajectoryIntake
from armsim_ros.control.trajectory.loop import (
    check_configuration,
    TrajectoryLoop,
    warn_of_configuration,
)
from armsim_ros.control.trajectory.tolerances import JointTolerance, SegmentTolerances
from armsim_ros.errors import ControllerError
from armsim_ros.trajectory import JointTrajectory


class JointTrajectoryController(Controller[JointTrajectoryControllerParameters]):
    """Follows joint trajectories from an action or a topic."""

    parameters_class: ClassVar[type[Settings]] = JointTrajectoryControllerParameters

    def on_init(self) -> None:
        """Look up the joints and make the intake of trajectories."""
        self._properties = JointProperties.of(self.parameters.joints, self.context.model)
        self._intake = TrajectoryIntake(self._properties, self.snapshot)
        self._publish_rate = Rate(self.parameters.state_publish_rate or math.inf)
        self._topic_warning = RepeatedWarning(self.events)
        self._loop: TrajectoryLoop | None = None

    @property
    def joints(self) -> tuple[str, ...]:
        """Controlled joints, in the order of all arrays."""
        return self.parameters.joints

    @property
    def required_command_interfaces(self) -> tuple[str, ...]:
        """Every command interface of every commanded joint, and that of the pace."""
        joints = self.parameters.commanded
        pace = self.parameters.speed_scaling.command_interface
        return (*(f'{j}/{kind}' for j in joints for kind in self.parameters.command_interfaces),
                *((pace,) if pace else ()))

    @property
    def required_state_interfaces(self) -> tuple[str, ...]:
        """Every state interface of every joint, and those of the pace."""
        kinds = self.parameters.state_interfaces
        pace = (self.parameters.speed_scaling.state_interface, self._given_pace)
        return (*(f'{joint}/{kind}' for joint in self.joints for kind in kinds),
                *dict.fromkeys(filter(None, pace)))

    @property
    def _given_pace(self) -> str:
        """The interface of the pace that the simulation itself has, '' where it has none."""
        name: str = getattr(self.parameters, 'speed_scaling_interface_name', '')
        return name

    @property
    def subscribes_speed_scaling(self) -> bool:
        """Whether the pace can be changed: only where positions alone are commanded."""
        return self.parameters.command_interfaces == ('position',)

    @property
    def active_goal(self) -> TrajectoryGoal | None:
        """The goal that is followed, or that waits for its stamp."""
        return self._loop.execution.active_goal if self._loop is not None else None

    def configure(self) -> None:
        """Check the parameters against the hardware and allocate what updates need."""
        parameters = self.parameters
        hardware, source = self.context.hardware, parameters.speed_source
        if source and (source == self._given_pace or source in hardware.other_states):
            hardware.given_states.setdefault(source, parameters.initial_pace)
        check_configuration(parameters, self.context.hardware)
        warn_of_configuration(parameters, self.events, self.time_ns)
        self._loop = TrajectoryLoop(
            lambda: self.parameters, self.context, self._properties, self.events, self.time_ns)

    def activate(self, time_ns: int) -> None:
        """Hold the joints where they are."""
        self.time_ns = time_ns
        self._configured.activate(time_ns)

    def deactivate(self, time_ns: int) -> None:
        """Abort the goal; positions stay commanded, all else stops."""
        self._configured.deactivate('the controller was deactivated')

    def interrupt(self, time_ns: int, reason: str) -> None:
        """Abort the goal with the reason."""
        self._configured.deactivate(reason)

    def update(self, time_ns: int, period: float) -> None:
        """Run an update, see :class:`TrajectoryLoop`."""
        self.time_ns = time_ns
        self._configured.update(time_ns, period)

    def process_requests(self, time_ns: int) -> None:
        """Take goals and cancels up while time is paused."""
        self._configured.process_requests(time_ns)

    def next_update(self, time_ns: int) -> int:
        """Return from when on an update matters [ns]: not while the joints are held."""
        return self._configured.next_update(time_ns)

    def plan(self, updates: int, period: float) -> int:
        """Plan updates along the trajectory."""
        return self._configured.plan(updates, period)

    def pass_updates(self, updates: int, period: float) -> None:
        """Be so many updates further along the trajectory, or after its end."""
        self._configured.pass_updates(updates, period)

    def check_goal(self, trajectory: JointTrajectory) -> str:
        """Return why a goal with this trajectory would be refused, '' where it would not."""
        try:
            self._check_acceptance(())
            self._intake.goal(trajectory, (), (), 0.0, self.parameters, self.time_ns)
        except RefusedTrajectoryError as error:
            return error.reason
        return ''

    def send_goal(
        self, trajectory: JointTrajectory, path_tolerances: Sequence[JointTolerance] = (),
        goal_tolerances: Sequence[JointTolerance] = (), goal_time_tolerance: float = 0.0
    ) -> GoalResponse:
        """
        Take a goal, which replaces a running goal at the next update, or refuse it.

        :param path_tolerances: on the way; joints that are not named keep the defaults.
        :param goal_tolerances: at the goal.
        :param goal_time_tolerance: 0 for the default, -1 for no bound [s].
        """
        try:
            loop = self._check_acceptance(goal_tolerances)
            request, goal, warnings = self._intake.goal(
                trajectory, path_tolerances, goal_tolerances, goal_time_tolerance, self.parameters,
                self.time_ns)
        except RefusedTrajectoryError as error:
            return self._refuse(trajectory, error)
        for text in warnings:
            self.events.warn(self.time_ns, text)
        loop.inbox.post(request)
        if not self.active:
            loop.abort_pending('the controller was deactivated')
        elif obstacle := self.obstacle:
            loop.abort_pending(obstacle)
        return GoalResponse(True, goal=goal)

    def cancel(self, goal: TrajectoryGoal) -> bool:
        """Cancel a goal and stop; False where it has ended already."""
        if self._loop is None or not goal.request_cancel():
            return False
        self._loop.inbox.post(CancelRequest(goal))
        return True

    def cancel_all(self) -> None:
        """Cancel whatever goal is active when the next update begins."""
        if self._loop is not None and self.active:
            self._loop.inbox.post(CancelRequest(None))

    def set_trajectory(self, trajectory: JointTrajectory) -> str | None:
        """Take a trajectory from the topic; None, or the reason why it is dropped."""
        try:
            loop = self._check_active()
            request, warning = self._intake.topic(trajectory, self.parameters, self.time_ns)
        except RefusedTrajectoryError as error:
            text = f'trajectory dropped: {error.reason}'
            self.events.add(self.time_ns, 'error', 'trajectory_rejected', text)
            return error.reason
        if warning:
            self._topic_warning.add(self.time_ns, warning, 'limits')
        loop.inbox.post(request)
        return None

    def set_speed_scaling(self, factor: float) -> bool:
        """Change the pace of trajectories; False where it is refused."""
        if self._loop is None or not self.subscribes_speed_scaling or not 0.0 <= factor < math.inf:
            text = f'speed scaling factor {factor:g} ignored; allowed: 0 or more'
            if not self.subscribes_speed_scaling:
                text = 'speed scaling ignored: it needs command_interfaces [position]'
            self.events.warn(self.time_ns, text)
            return False
        if self.parameters.speed_source:
            self.context.hardware.given_states[self.parameters.speed_source] = factor
        else:
            self._loop.wanted_scaling = factor
        self.context.wake()
        return True

    def snapshot(self) -> ControllerSnapshot | None:
        """Return the state of the last update, None before the first activation."""
        if self._loop is None:
            return None
        parameters = self.parameters
        return snapshot_of(
            self._loop.ring, self.joints, parameters.state_interfaces,
            parameters.command_interfaces)

    def query_state(self, time_ns: int) -> QueryResult:
        """Sample the running trajectory at an absolute time [ns]."""
        snapshot = self.snapshot() if self.active else None
        if snapshot is None:
            return QueryResult(False, f"controller '{self.name}' is not active")
        return query(snapshot, time_ns)

    def publish_due(self, time_ns: int) -> bool:
        """Return whether ``controller_state`` is to be published now; for a single thread."""
        return self._publish_rate.due(time_ns)

    @property
    def _configured(self) -> TrajectoryLoop:
        if self._loop is None:
            raise ControllerError(f"controller '{self.name}' is not configured")
        return self._loop

    def _check_active(self) -> TrajectoryLoop:
        if self._loop is None or not self.active:
            raise RefusedTrajectoryError(
                f"controller '{self.name}' is {self.state.value}, only an active controller takes "
                'trajectories')
        if obstacle := self.obstacle:
            raise RefusedTrajectoryError(obstacle)
        return self._loop

    def _check_acceptance(self, goal_tolerances: Sequence[JointTolerance]) -> TrajectoryLoop:
        """
        Return what follows a goal.

        :raises RefusedTrajectoryError: no goal with these tolerances is taken now.
        """
        return self._check_active()

    def _refuse(self, trajectory: JointTrajectory, error: RefusedTrajectoryError) -> GoalResponse:
        text = f'goal rejected: {error.reason}'
        self.events.add(self.time_ns, 'error', 'goal_rejected', text)
        if self.parameters.refused_goals == 'reject':
            return GoalResponse(False, error.reason, error.code)
        goal = TrajectoryGoal(trajectory, SegmentTolerances.of(self.parameters))
        goal.finish(GoalStatus.ABORTED, TrajectoryResult(error.code, error.reason))
        return GoalResponse(True, error.reason, error.code, goal)


class ScaledJointTrajectoryController(JointTrajectoryController):
    """``ur_controllers/ScaledJointTrajectoryController``: time goes at the robot's pace."""

    parameters_class: ClassVar[type[Settings]] = ScaledJointTrajectoryControllerParameters


class PassthroughTrajectoryController(ScaledJointTrajectoryController):
    """
    ``ur_controllers/PassthroughTrajectoryController``, for whose clients the arm interpolates.

    Here the controller does, which makes no difference to them. As upstream no goal is replaced
    by another.
    """

    parameters_class: ClassVar[type[Settings]] = PassthroughTrajectoryControllerParameters

    def on_init(self) -> None:
        """Have no goal."""
        super().on_init()
        self._taken: TrajectoryGoal | None = None

    def send_goal(
        self, trajectory: JointTrajectory, path_tolerances: Sequence[JointTolerance] = (),
        goal_tolerances: Sequence[JointTolerance] = (), goal_time_tolerance: float = 0.0
    ) -> GoalResponse:
        """
        Take a goal, or refuse it; one that comes while another runs is refused.

        :param path_tolerances: on the way; joints that are not named keep the defaults.
        :param goal_tolerances: at the goal; none, or those of all joints.
        :param goal_time_tolerance: 0 for the default, -1 for no bound [s].
        """
        response = super().send_goal(
            trajectory, path_tolerances, goal_tolerances, goal_time_tolerance)
        if response.goal is not None and not response.goal.done:
            self._taken = response.goal
        return response

    def _check_acceptance(self, goal_tolerances: Sequence[JointTolerance]) -> TrajectoryLoop:
        loop, taken = super()._check_acceptance(goal_tolerances), self._taken
        if taken is not None and not taken.done and taken.status is not GoalStatus.CANCELING:
            raise RefusedTrajectoryError(
                'another trajectory is being executed; wait for its end, or cancel it')
        names = [tolerance.name for tolerance in goal_tolerances]
        if names and sorted(names) != sorted(self.joints):
            raise RefusedTrajectoryError(
                f'goal tolerances are of {", ".join(names)}; allowed: none, or one of each of '
                f'{", ".join(self.joints)}')
        return loop
