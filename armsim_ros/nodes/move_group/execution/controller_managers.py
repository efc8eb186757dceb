# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where move_group knows its controllers from, and which part of a trajectory each gets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from controller_manager_msgs.srv import ListControllers, SwitchController
from rclpy.client import Client

from armsim_ros.config.trajectory_execution import (
    MoveItControllerSettings,
    TrajectoryExecutionSettings,
)
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import (
    controlled_joints,
    MultiDofTrajectory,
    select_controllers,
)
from armsim_ros.execution.ros2_control import ListedController, ManagedControllers
from armsim_ros.execution.rules import check_points, Tolerances
from armsim_ros.nodes.move_group.context import Context
from armsim_ros.nodes.move_group.execution.controller_handles import ControllerHandle
from armsim_ros.trajectory import JointTrajectory

SOURCE = 'trajectory_execution'
_PACKAGE = 'moveit_ros_control_interface/'
#: Names of the plugins -> whether all controller_managers are used.
_MANAGERS = {
    f'{_PACKAGE}Ros2ControlManager': False,
    f'{_PACKAGE}MoveItControllerManager': False,
    f'{_PACKAGE}Ros2ControlMultiManager': True,
    f'{_PACKAGE}MoveItMultiControllerManager': True,
}
_LIST = 'controller_manager/list_controllers'
#: The controllers are read again where they are older than this [s] of wall time.
_VALIDITY = 1.0


class SimpleControllerManager:
    """The controllers of ``moveit_simple_controller_manager``; all of them count as active."""

    def __init__(self, context: Context) -> None:
        self._context = context
        self._handles: dict[str, ControllerHandle] = {}
        #: What trajectories can be sent to.
        self.controllers: tuple[MoveItControllerSettings, ...] = ()
        #: Names of those that run, None where all do.
        self.active: frozenset[str] | None = None
        self._know(context.settings.moveit_controllers)

    def _know(self, controllers: Sequence[MoveItControllerSettings]) -> None:
        """Replace the known controllers; handles of those that have not changed stay."""
        self.controllers = tuple(controllers)
        known = {each.name: each for each in controllers}
        for name, handle in tuple(self._handles.items()):
            if known.get(name) != handle.settings:
                del self._handles[name]
                handle.close()
        for name, each in known.items():
            if name not in self._handles and self._takes_trajectories(each):
                self._handles[name] = ControllerHandle(
                    self._context.node, each, self._context.ticker.wake)

    def _takes_trajectories(self, each: MoveItControllerSettings) -> bool:
        """Return whether a controller has an action."""
        return True

    def handle(self, name: str) -> ControllerHandle:
        """
        Return the client of a controller.

        :raises PlanningError: CONTROL_FAILED for a controller without an action.
        """
        if name not in self._handles:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{name}' cannot be sent trajectories: its type has no such action",
                SOURCE)
        return self._handles[name]

    async def refresh(self) -> None:
        """Find out which controllers there are."""

    async def switch(self, activate: Sequence[str], deactivate: Sequence[str]) -> None:
        """Activate and deactivate controllers; here all are active always."""


class Ros2ControlManager(SimpleControllerManager):
    """
    The controllers of running controller_managers, which are asked before each execution.

    :param every: whether all managers that are found are used, not only that of
        ``ros_control_namespace``.
    """

    def __init__(self, context: Context, *, every: bool) -> None:
        super().__init__(context)
        settings = context.execution_settings
        self._timeout = settings.controller_service_call_timeout
        self._every = every
        self._namespaces = () if every else (f'/{settings.ros_control_namespace.strip("/")}',)
        self._clients: dict[tuple[str, Any], Client] = {}
        self._managed: tuple[ManagedControllers, ...] = ()
        self._read_at = float('-inf')
        self.active = frozenset()
        self._know(())

    async def refresh(self) -> None:
        """Ask the managers, at most once a second."""
        if self._context.clock() - self._read_at >= _VALIDITY:
            await self._read()

    async def switch(self, activate: Sequence[str], deactivate: Sequence[str]) -> None:
        """
        Activate and deactivate controllers in one strict switch of each manager.

        :raises PlanningError: CONTROL_FAILED where a manager refuses or does not answer.
        """
        await self._read()
        for managed in self._managed:
            starting, stopping = managed.switch(activate, deactivate)
            if not (starting or stopping):
                continue
            request = SwitchController.Request(
                activate_controllers=starting, deactivate_controllers=stopping,
                strictness=SwitchController.Request.STRICT)
            self._context.logger.info(
                f'{SOURCE}: activating {_names(starting)}, deactivating {_names(stopping)}')
            answer = await self._call(managed.namespace, SwitchController, request)
            if answer is None or not answer.ok:
                reason = 'no answer' if answer is None else answer.message
                raise PlanningError(
                    MoveItErrorCode.CONTROL_FAILED,
                    f'activating {_names(starting)} and deactivating {_names(stopping)} failed: '
                    f'{reason or "see the log of the controller_manager"}', SOURCE)
        await self._read()

    def _takes_trajectories(self, each: MoveItControllerSettings) -> bool:
        """Return whether a controller has an action."""
        return bool(each.action_ns)

    async def _read(self) -> None:
        self._read_at = self._context.clock()
        found = []
        for namespace in self._found() if self._every else self._namespaces:
            answer = await self._call(namespace, ListControllers, ListControllers.Request())
            if answer is not None:
                found.append(ManagedControllers(namespace, tuple(
                    ListedController(
                        controller.name, controller.type, controller.state == 'active',
                        tuple(controller.claimed_interfaces),
                        tuple(controller.required_command_interfaces),
                        tuple(chain.name for chain in controller.chain_connections),
                        tuple(controller.reference_interfaces))
                    for controller in answer.controller)))
            else:
                self._context.logger.warning(
                    f"{SOURCE}: no answer of '{namespace.rstrip('/')}/{_LIST}' within "
                    f'{self._timeout:g} s; does the controller_manager run there '
                    '(ros_control_namespace)?')
        if found:
            self._managed = tuple(found)
        self.active = frozenset().union(*(managed.active for managed in self._managed))
        self._know([each for managed in self._managed for each in managed.settings])

    def _found(self) -> list[str]:
        """Return the namespaces of all controller_managers."""
        services = self._context.node.get_service_names_and_types()
        return sorted(
            name.removesuffix(_LIST) for name, _ in services if name.endswith(f'/{_LIST}'))

    async def _call(self, namespace: str, kind: Any, request: Any) -> Any:
        """Return the answer of a manager's service, None where none comes in time."""
        context = self._context
        if (namespace, kind) not in self._clients:
            name = 'list_controllers' if kind is ListControllers else 'switch_controller'
            self._clients[namespace, kind] = context.node.create_client(
                kind, f'{namespace.rstrip("/")}/controller_manager/{name}',
                callback_group=context.group)
        client = self._clients[namespace, kind]
        deadline = context.clock() + self._timeout
        while not client.service_is_ready():
            if context.clock() > deadline or context.ending:
                return None
            await context.ticker.next()
        future = client.call_async(request)
        while not future.done():
            if context.clock() > deadline or context.ending:
                client.remove_pending_request(future)
                return None
            await context.ticker.next()
        return future.result()


def controller_manager(context: Context) -> SimpleControllerManager:
    """Return what ``moveit_controller_manager`` names; the simple manager for any other name."""
    name = context.execution_settings.moveit_controller_manager
    if name not in _MANAGERS:
        return SimpleControllerManager(context)
    every = _MANAGERS[name]
    if 'Ros2Control' not in name:
        context.logger.warning(
            f'{name} is deprecated; use {_PACKAGE}Ros2Control{"Multi" if every else ""}Manager')
    return Ros2ControlManager(context, every=every)


def _names(controllers: Sequence[str]) -> str:
    return ', '.join(controllers) or 'none'


#: The part of a controller.
Part = tuple[MoveItControllerSettings, JointTrajectory, MultiDofTrajectory | None]


def start_tolerances(context: Context) -> Tolerances:
    """Return how far a trajectory may begin from where the robot is."""
    settings = context.execution_settings
    return Tolerances(settings.allowed_start_tolerance, settings.allowed_start_tolerance_joints)


def selected_controllers(
    context: Context, controllers: SimpleControllerManager, trajectory: JointTrajectory,
    names: Sequence[str], multi_dof: MultiDofTrajectory | None = None,
) -> tuple[MoveItControllerSettings, ...]:
    """
    Return the controllers of a trajectory; none where it has no points.

    :raises PlanningError: CONTROL_FAILED where it cannot be executed.
    """
    check_points(trajectory)
    joints = [*(trajectory.joint_names if len(trajectory) else ()),
              *(multi_dof.joint_names if multi_dof is not None else ())]
    if not len(trajectory) and multi_dof is None:
        return ()
    return select_controllers(
        controlled_joints(joints, context.robot), controllers.controllers, names=tuple(names),
        active=controllers.active,
        manages=context.execution_settings.moveit_manage_controllers)


def multi_dof_part(
    controller: MoveItControllerSettings, multi_dof: MultiDofTrajectory | None,
    settings: TrajectoryExecutionSettings,
) -> MultiDofTrajectory | None:
    """Return what the multi-DOF joints of a controller do, None where it has none."""
    names = [name for name in (multi_dof.joint_names if multi_dof is not None else ())
             if name in controller.joints]
    if multi_dof is None or not names:
        return None
    return multi_dof.of_joints(sorted(names), settings.execution_velocity_scaling)
