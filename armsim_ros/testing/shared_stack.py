# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Programs that serve several tests one after the other, each from the same start."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from contextlib import ExitStack
from typing import Any

from moveit_msgs.msg import PlanningSceneComponents
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from rcl_interfaces.srv import GetParameters
from simulation_interfaces.msg import Result, SimulationState
from simulation_interfaces.srv import ResetSimulation, SetSimulationState

from armsim_ros.testing.controller_manager_client import ControllerManagerClient
from armsim_ros.testing.parameter_client import ParameterClient
from armsim_ros.testing.robot_user import RobotUser, running_robot

#: Everything that a scene consists of but the robot's state.
_SCENE = PlanningSceneComponents(components=sum((
    PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS,
    PlanningSceneComponents.WORLD_OBJECT_NAMES,
    PlanningSceneComponents.WORLD_OBJECT_GEOMETRY,
    PlanningSceneComponents.TRANSFORMS,
    PlanningSceneComponents.ALLOWED_COLLISION_MATRIX,
    PlanningSceneComponents.LINK_PADDING_AND_SCALING,
    PlanningSceneComponents.OBJECT_COLORS,
)))


#: The planner knows what a test tells it, as in the test's own process; a test may ask for more.
WITHOUT_WORLD = 'scene_from_world:=false'


class SharedStack:
    """
    A stack that is put back to its start, or started anew where that does not do.

    :param domain: ROS domain id that the caller has leased.
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._stack = ExitStack()
        self._key: Hashable = None
        self._robot: RobotUser | None = None
        self._start: Any = None
        self._scene: Any = None

    def at_start(self, key: Hashable, arguments: Sequence[str], namespace: str) -> RobotUser:
        """
        Return a stack as it is after its start.

        A reset takes arm and objects back and ends goals; the planning scene becomes what it was.
        Where controllers or parameters differ from those of the start the programs are ended and
        started again.

        :param key: equal for requests that one stack can serve.
        :param arguments: of bringup.
        :param namespace: where the robot's controllers are.
        """
        if self._robot is not None and key == self._key and self._reset(self._robot):
            return self._robot
        self.close()
        robot = self._stack.enter_context(
            running_robot(WITHOUT_WORLD, *arguments, domain=self._domain, namespace=namespace))
        self._key, self._robot = key, robot
        self._start, self._scene = self._settings(robot), self._planning_scene(robot)
        return robot

    def close(self) -> None:
        """End the programs."""
        self._robot = None
        self._stack.close()

    def _reset(self, robot: RobotUser) -> bool:
        """Put the stack back to its start; False where that takes new programs."""
        if robot.program.process.poll() is not None or self._settings(robot) != self._start:
            return False
        call = robot.client.call
        play = SetSimulationState.Request()
        play.state.state = SimulationState.STATE_PLAYING
        call('/set_simulation_state', SetSimulationState, play)
        scope = ResetSimulation.Request.SCOPE_STATE | ResetSimulation.Request.SCOPE_SPAWNED
        reset = call('/reset_simulation', ResetSimulation, ResetSimulation.Request(scope=scope))
        scene = ApplyPlanningScene.Request(scene=self._scene)
        applied = call('/apply_planning_scene', ApplyPlanningScene, scene)
        return bool(reset.result.result == Result.RESULT_OK and applied.success)

    @staticmethod
    def _settings(robot: RobotUser) -> Any:
        """Return what a reset does not take back: controllers, and parameters of all nodes."""
        manager = f'{robot.namespace}/controller_manager'
        states = ControllerManagerClient(robot.client, manager).states()
        nodes = [manager, '/move_group', *(f'{robot.namespace}/{name}' for name in states)]
        parameters = {}
        for node in nodes:
            names = sorted(ParameterClient(robot.client, node).names())
            answer = robot.client.call(
                f'{node}/get_parameters', GetParameters, GetParameters.Request(names=names))
            parameters[node] = (names, repr(answer.values))
        return states, parameters

    @staticmethod
    def _planning_scene(robot: RobotUser) -> Any:
        request = GetPlanningScene.Request(components=_SCENE)
        return robot.client.call('/get_planning_scene', GetPlanningScene, request).scene
