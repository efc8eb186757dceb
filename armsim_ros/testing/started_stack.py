# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Running programs that tests share, and how they are put back to their start."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

from controller_manager_msgs.srv import ListControllers
from moveit_msgs.msg import PlanningSceneComponents
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene
from rcl_interfaces.srv import GetParameters, ListParameters
from simulation_interfaces.srv import ResetSimulation, SetSimulationState

from armsim_ros.clients.controller_manager import ControllerManagerClient, ParameterClient
from armsim_ros.clients.simulation import SimulationClient
from armsim_ros.errors import SimulationError
from armsim_ros.testing.program import start_program
from armsim_ros.testing.robot_user import RobotUser

#: Everything that a scene consists of but the robot's state.
_SCENE = PlanningSceneComponents(components=sum((
    PlanningSceneComponents.ROBOT_STATE_ATTACHED_OBJECTS,
    PlanningSceneComponents.WORLD_OBJECT_NAMES, PlanningSceneComponents.WORLD_OBJECT_GEOMETRY,
    PlanningSceneComponents.TRANSFORMS, PlanningSceneComponents.ALLOWED_COLLISION_MATRIX,
    PlanningSceneComponents.LINK_PADDING_AND_SCALING, PlanningSceneComponents.OBJECT_COLORS)))
_SERVICES = {
    '/apply_planning_scene': ApplyPlanningScene, '/get_planning_scene': GetPlanningScene,
    '/reset_simulation': ResetSimulation, '/set_simulation_state': SetSimulationState,
}


class StartedStack:
    """
    Programs as they are after their start.

    :param robot: the user's view of them.
    """

    def __init__(self, robot: RobotUser) -> None:
        """Note what a reset does not take back."""
        self.robot = robot
        self._manager = f'{robot.namespace}/controller_manager'
        # At once: clients that connect to a service wait until its server has noticed.
        robot.client.connect({
            **_SERVICES, f'{self._manager}/list_controllers': ListControllers,
            **_parameter_services(self._manager, '/move_group')})
        self._start = self._settings()
        request = GetPlanningScene.Request(components=_SCENE)
        self._scene = robot.client.call('/get_planning_scene', GetPlanningScene, request).scene

    def put_back(self) -> bool:
        """Put all back to the start; False where that takes new programs."""
        if self.robot.program.process.poll() is not None:
            return False
        try:
            return self._settings() == self._start and self._reset()
        except (AssertionError, SimulationError):  # a program no longer answers, or refuses
            return False

    def _reset(self) -> bool:
        simulation = SimulationClient(self.robot.client)
        simulation.play()
        simulation.reset()
        scene = ApplyPlanningScene.Request(scene=self._scene)
        return bool(self.robot.client.call(
            '/apply_planning_scene', ApplyPlanningScene, scene).success)

    def _settings(self) -> Any:
        """Return controllers, and parameters of all nodes."""
        client = self.robot.client
        states = ControllerManagerClient(client, self._manager).states()
        nodes = [self._manager, '/move_group',
                 *(f'{self.robot.namespace}/{name}' for name in states)]
        client.connect(_parameter_services(*nodes))
        parameters = {}
        for node in nodes:
            names = sorted(ParameterClient(client, node).names())
            answer = client.call(
                f'{node}/get_parameters', GetParameters, GetParameters.Request(names=names))
            parameters[node] = (names, repr(answer.values))
        return states, parameters


def _parameter_services(*nodes: str) -> dict[str, type]:
    return {f'{node}/{name}': kind for node in nodes for name, kind in (
        ('get_parameters', GetParameters), ('list_parameters', ListParameters))}


#: The planner knows what a test gives it, as in the test's own process; a test may request more.
WITHOUT_WORLD = 'scene_from_world:=false'


class SharedStack:
    """
    A stack that is put back to its start, or started anew where that does not do.

    :param domain: ROS domain id that the caller has leased.
    """

    def __init__(self, domain: int) -> None:
        self._domain = domain
        self._stack = ExitStack()
        self._arguments: Sequence[str] = ()
        self._started: StartedStack | None = None

    def at_start(self, arguments: Sequence[str], namespace: Callable[[], str]) -> RobotUser:
        """
        Return a stack as it is after its start.

        A reset takes arm and objects back and ends goals; the planning scene becomes what it was.
        Where controllers or parameters differ from those of the start, or the programs answer no
        more, they are ended and started again.

        :param arguments: of bringup; equal for requests that one stack can serve.
        :param namespace: returns where the robot's controllers are; called while programs start.
        """
        if self._started is None or arguments != self._arguments or not self._started.put_back():
            self.close()
            with ExitStack() as starting:
                program = starting.enter_context(
                    start_program('bringup', self._domain, WITHOUT_WORLD, *arguments))
                # What takes long to import, and to read, comes while the programs start.
                from armsim_ros.testing.robot_user import user_of

                robot = starting.enter_context(user_of(program, self._domain, namespace()))
                self._started, self._arguments = StartedStack(robot), arguments
                self._stack = starting.pop_all()
        return self._started.robot

    def close(self) -> None:
        """End the programs."""
        self._started = None
        self._stack.close()
