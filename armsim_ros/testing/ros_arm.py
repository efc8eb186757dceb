# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The arm of programs that run by themselves, moved through their public interfaces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
import json
from pathlib import Path
import shutil
from typing import Any

import numpy as np
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Empty, SetBool, Trigger

from armsim_ros.arrays import Matrix
from armsim_ros.clients.client_node import LATCHED
from armsim_ros.clients.controller_goals import send_parts
from armsim_ros.clients.controller_manager import ControllerManagerClient
from armsim_ros.clients.motion import code_text, SUCCESS
from armsim_ros.clients.simulation import SimulationClient
from armsim_ros.config.controllers.gripper_action_controller import (
    GripperParameters,
    ParallelGripperActionControllerParameters,
)
from armsim_ros.config.simulation import JointFault
from armsim_ros.config.trajectory_execution import MoveItControllerSettings
from armsim_ros.config.world import WorldObjectSettings
from armsim_ros.errors import ControllerError, PlanningError
from armsim_ros.execution.controller_selection import controller_parts
from armsim_ros.model.cell import Cell
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.testing.arm import Arm, BUILT_WITHOUT_FAULTS, Points, Target, Touch
from armsim_ros.testing.robot_user import AT_REST, RobotUser
from armsim_ros.trajectory import JointTrajectory

SECOND_NS = 1_000_000_000


class RosArm(Arm):
    """
    A robot of a running stack.

    :param robot: the user's view of the stack.
    :param cell: the files that it was started with.
    :param seed: of the planner's random numbers, with which it was started.
    :param time_limit: wall time that a motion may take [s].
    """

    def __init__(
        self, robot: RobotUser, cell: Cell, *, seed: int = 0, time_limit: float = 60.0
    ) -> None:
        """Wait for the first joint state, from which on time counts."""
        super().__init__(cell.model, seed)
        settings = cell.settings
        #: The user's view of the stack.
        self.robot = robot
        self._simulation = SimulationClient(robot.client)
        self._time_limit = time_limit
        self._has_faults = settings.simulation.fault_injection
        self._controllers = settings.moveit_controllers
        self._cups = tuple(settings.simulation.vacuum_grippers)
        self._grippers = [
            _gripper(f'{robot.namespace}/{controller.name}', controller.parameters)
            for controller in settings.controllers
            if isinstance(controller.parameters, GripperParameters)
            and controller.name in settings.spawn]
        self._states = robot.client.collect(f'{robot.namespace}/joint_states', JointState)
        self._start_ns = _stamp_ns(self._present())

    @property
    def time(self) -> float:
        """Simulated time since the test began [s]."""
        return self._since_start(self._present())

    @property
    def positions(self) -> dict[str, float]:
        """Joint -> position [rad or m]."""
        return _positions(self._present())

    def move_to(self, target: Target, *, group: str = '', speed: float = 1.0) -> None:
        """Plan a motion, execute it, and wait for its end."""
        group = group or self._model.semantic.first_group
        goal = (self._model.semantic.named_state(group, target) if isinstance(target, str)
                else self.state(target))
        result = self.robot.move_group.move(
            group, goal, timeout=self._time_limit, max_velocity_scaling_factor=float(speed))
        code = result.error_code
        if code.val == SUCCESS:
            return
        if result.planned_trajectory.joint_trajectory.points:
            raise ControllerError(code_text(code))
        raise PlanningError(code.val, code.message, code.source)

    def follow(self, points: Points) -> None:
        """Have the controllers run a trajectory as it is, and wait until the arm rests."""
        trajectory = self.trajectory(points)
        try:
            sent = send_parts(
                self.robot.client, controller_parts(trajectory, self._model, self._controllers))
        except PlanningError as error:
            raise ControllerError(str(error)) from None
        for failure in [goal.failure(self._time_limit) for goal in sent]:
            if failure:
                raise ControllerError(failure)
        self._wait_for_rest(trajectory.joint_names)

    def wait(self, seconds: float) -> None:
        """Wait until simulated time has moved on [s]."""
        end_ns = _stamp_ns(self._present()) + round(seconds * SECOND_NS)
        self._states.wait_for(lambda message: _stamp_ns(message) >= end_ns, self._time_limit)

    def _wait_for_rest(self, joints: Sequence[str]) -> None:
        """Wait until these joints have come to rest, for a second of simulated time at most."""
        begin_ns = _stamp_ns(self._present())

        def rests(state: JointState) -> bool:
            passed_ns = _stamp_ns(state) - begin_ns
            return passed_ns >= SECOND_NS or (passed_ns >= 0 and not any(
                abs(velocity) >= AT_REST
                for name, velocity in zip(state.name, state.velocity, strict=False)
                if name in joints))

        self._states.wait_for(rests)

    def _present(self) -> JointState:
        """Return the present state; messages on their way to a busy process may be older."""
        self._states.clear()
        now_ns = int(self.robot.client.call('/simulation/sync', Trigger).message)
        state: JointState = self._states.wait_for(lambda message: _stamp_ns(message) >= now_ns)
        return state

    def _since_start(self, state: JointState) -> float:
        return (_stamp_ns(state) - self._start_ns) / SECOND_NS

    def fault(self, joint: str, **fault: Any) -> None:
        """Make a joint fail from now on, or be well again where nothing is given."""
        if not self._has_faults:
            raise ControllerError(BUILT_WITHOUT_FAULTS)
        well = {kind: value.default for kind, value in JointFault.model_fields.items()}
        try:
            self.robot.fault(joint, **{**well, **fault})
        except AssertionError as refusal:
            raise ControllerError(str(refusal)) from None

    def protective_stop(self, cause: str = 'injected') -> None:
        """
        Stop the arm: goals end, the joints brake and are held until ``clear_stop``.

        :param cause: only ``injected``; a running stack has no service with another.
        """
        if cause != 'injected':
            raise NotImplementedError("causes have names with armsim(mode='inprocess') only")
        self.robot.client.call(f'{self.robot.namespace}/protective_stop', SetBool,
                               SetBool.Request(data=True))
        self._safety(lambda state: state.endswith('_STOP'))

    def clear_stop(self) -> None:
        """
        End a protective stop.

        :raises ControllerError: it goes on; with the reason.
        """
        answer = self.robot.client.call(f'{self.robot.namespace}/clear_stop', Trigger)
        if not answer.success:
            raise ControllerError(answer.message)
        self._safety(lambda state: not state.endswith('_STOP'))

    @property
    def safety(self) -> str:
        """State of the safety of the robot, such as ``NORMAL``."""
        return self._safety(lambda _: True)

    def _safety(self, matches: Callable[[str], bool]) -> str:
        """Return the state of the safety once it matches."""
        def state(message: String) -> str:
            return str(json.loads(message.data)['safety'])
        states = self.robot.client.collect(f'{self.robot.namespace}/safety', String, LATCHED)
        found = state(states.wait_for(lambda message: matches(state(message))))
        states.close()
        return found

    def _switch(self, controller: str, *, active: bool) -> None:
        """Activate or deactivate a controller."""
        manager = ControllerManagerClient(
            self.robot.client, f'{self.robot.namespace}/controller_manager')
        named = [controller]
        response = manager.switch(activate=named) if active else manager.switch(deactivate=named)
        if not response.ok:
            raise ControllerError(response.message)

    def _switch_cups(self, *, on: bool) -> bool:
        """Call the services of the suction cups."""
        for cup in self._cups:
            service = f"{self.robot.namespace}/{cup}/{'on' if on else 'off'}"
            self.robot.client.call(service, Empty)
        return bool(self._cups)

    def held(self) -> tuple[str, ...]:
        """Raise; the planning scene of a test's stack does not follow the world."""
        raise NotImplementedError("what is held is known with armsim(mode='inprocess') only")

    def _command_grippers(self, state: Mapping[str, float], effort: float) -> bool:
        """Send the spawned gripper controllers goals; what is between fingers may stop them."""
        parts = [
            (gripper.model_copy(update={'max_effort': effort}),
             JointTrajectory(gripper.joints, np.zeros(1), np.array([[state[gripper.joints[0]]]])))
            for gripper in self._grippers if gripper.joints[0] in state]
        for goal in send_parts(self.robot.client, parts):
            goal.failure(self._time_limit)
        return bool(parts)

    def _spawn(self, name: str, item: WorldObjectSettings) -> None:
        """Have the simulation spawn it."""
        words = item.parts[0].shape.model_dump()
        kind = words.pop('type')
        words['friction'] = item.friction
        if item.mass is not None:
            words['mass'] = item.mass
        query = '&'.join(f'{word}={_text(value)}' for word, value in words.items())
        self._simulation.spawn(name, f'armsim://{kind}?{query}', pose_matrix(item.xyz, item.rpy))

    def delete(self, name: str) -> None:
        """
        Take an object out of the world.

        :raises SimulationError: there is none of that name.
        """
        self._simulation.delete(name)

    def entity(self, name: str) -> Matrix:
        """
        Return where an object is in the world (4, 4).

        :raises SimulationError: there is none of that name.
        """
        return self._simulation.pose(name)

    def digest(self) -> str:
        """Return the simulation's digest; of a run in real time no two are equal."""
        return str(self.robot.client.call('/simulation/digest', Trigger).message)

    def touches(self, since: float | None = None) -> tuple[Touch, ...]:
        """Raise; a running stack has no topic of its contacts."""
        raise NotImplementedError("contacts are known with armsim(mode='inprocess') only")

    def summary(self) -> str:
        """Return where the arm is, in a line."""
        state = self._present()
        at = ', '.join(f'{joint} {value:.4f}' for joint, value in _positions(state).items())
        return f'at {self._since_start(state):.3f} s: {at}'

    def event_lines(self) -> list[str]:
        """Return what the programs printed last."""
        return self.robot.program.text.splitlines()

    def save_artifacts(self, place: Path) -> Iterator[tuple[str, Path]]:
        """Write what the programs printed."""
        path = place.with_name(f'{place.name}.log')
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(self.robot.program.text, encoding='utf-8')
        yield 'log', path
        if self.robot.program.process.poll() is None:
            answer = self.robot.client.call('/simulation/dump', Trigger)
            if answer.success:
                recording = place.with_name(f'{place.name}.mcap')
                shutil.move(answer.message, recording)
                yield 'recording', recording


def _gripper(name: str, parameters: GripperParameters) -> MoveItControllerSettings:
    """Return the action of a gripper controller."""
    parallel = isinstance(parameters, ParallelGripperActionControllerParameters)
    return MoveItControllerSettings(
        name=name, type='ParallelGripperCommand' if parallel else 'GripperCommand',
        action_ns='gripper_cmd', joints=(parameters.joint,))


def _text(value: float | Sequence[float]) -> str:
    return repr(value) if isinstance(value, float) else ','.join(map(repr, value))


def _stamp_ns(message: JointState) -> int:
    return message.header.stamp.sec * SECOND_NS + message.header.stamp.nanosec


def _positions(state: JointState) -> dict[str, float]:
    return dict(zip(state.name, state.position, strict=True))
