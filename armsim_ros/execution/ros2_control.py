# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controllers of a controller_manager, as trajectory execution sees them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from armsim_ros.config.trajectory_execution import ActionType, MoveItControllerSettings
from armsim_ros.errors import MoveItErrorCode, PlanningError
from armsim_ros.execution.controller_selection import select_controllers

#: Type of a controller -> type and last part of the name of its action; '' where it has none, so
#: that it can be activated but not be sent a trajectory.
ACTIONS: Mapping[str, tuple[ActionType, str]] = {
    'joint_trajectory_controller/JointTrajectoryController':
        ('FollowJointTrajectory', 'follow_joint_trajectory'),
    'position_controllers/GripperActionController': ('GripperCommand', 'gripper_cmd'),
    'effort_controllers/GripperActionController': ('GripperCommand', 'gripper_cmd'),
    'parallel_gripper_action_controller/GripperActionController':
        ('ParallelGripperCommand', 'gripper_cmd'),
    'admittance_controller/AdmittanceController': ('FollowJointTrajectory', ''),
}


@dataclass(frozen=True, slots=True)
class ListedController:
    """
    A controller as ``list_controllers`` reports it.

    :param claimed: command interfaces that it holds, as ``joint/interface``.
    :param required: command interfaces that it holds when it is active.
    :param chained_to: controllers whose reference interfaces it commands.
    :param references: its own reference interfaces.
    """

    name: str
    type: str
    active: bool = False
    claimed: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    chained_to: tuple[str, ...] = ()
    references: tuple[str, ...] = ()


@dataclass(frozen=True)
class ManagedControllers:
    """
    The controllers of a controller_manager.

    :param namespace: of the manager, with a slash at its start; names have it in front.
    :param listed: as the manager reports them.
    """

    namespace: str = '/'
    listed: tuple[ListedController, ...] = ()
    _by_name: dict[str, ListedController] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Leave all controllers out where an active controller commands several others."""
        several = any(listed.active and len(listed.chained_to) > 1 for listed in self.listed)
        object.__setattr__(
            self, '_by_name', {} if several else {listed.name: listed for listed in self.listed})

    @property
    def settings(self) -> tuple[MoveItControllerSettings, ...]:
        """Those of a known type, by their absolute names."""
        found = []
        for controller in self._by_name.values():
            joints = self._joints(controller)
            if controller.type in ACTIONS and joints:
                kind, action = ACTIONS[controller.type]
                found.append(MoveItControllerSettings(
                    name=self._absolute(controller.name), type=kind, action_ns=action,
                    joints=joints))
        return tuple(found)

    @property
    def active(self) -> frozenset[str]:
        """Absolute names of those that are active."""
        return frozenset(self._absolute(controller.name) for controller in self._by_name.values()
                         if controller.active)

    def switch(
        self, activate: Iterable[str], deactivate: Iterable[str]
    ) -> tuple[list[str], list[str]]:
        """
        Return the controllers to activate and to deactivate in a strict switch.

        What those to be activated command is activated too, and before them; what commands those
        to be deactivated is deactivated too. Controllers of any type that hold a joint that is
        needed are deactivated. What is in both lists is left out of both.

        :param activate: absolute names; those of other managers are left out.
        :returns: names without the namespace.
        """
        commanded = {controller.name: controller.chained_to
                     for controller in self._by_name.values()}
        commanding = {
            name: tuple(controller.name for controller in self._by_name.values()
                        if name in controller.chained_to)
            for name in commanded}
        starting = self._with(activate, commanded, lambda name: not self._by_name[name].active)
        stopping = [name for name in self._with(
            deactivate, commanding, lambda name: self._by_name[name].active)
            if self._by_name[name].type in ACTIONS]
        starting = [name for name in reversed(starting) if self._by_name[name].type in ACTIONS]
        holder = {
            _joint(interface): controller.name for controller in self._by_name.values()
            if controller.active and controller.name not in stopping
            for interface in controller.claimed}
        for name in starting:
            for joint in self._joints(self._by_name[name]):
                if holder.get(joint, name) not in (name, *stopping):
                    stopping.append(holder[joint])
        both = set(starting) & set(stopping)
        return (
            [name for name in dict.fromkeys(starting) if name not in both],
            [name for name in dict.fromkeys(stopping) if name not in both])

    def _with(
        self, names: Iterable[str], related: Mapping[str, Sequence[str]],
        included: Callable[[str], bool]
    ) -> list[str]:
        """Return the manager's own names of controllers, and those related to them."""
        found = [name.rpartition('/')[2] for name in names
                 if self._absolute(name.rpartition('/')[2]) == name]
        found = queue = [name for name in found if name in self._by_name]
        while queue:
            queue = [other for name in queue for other in related[name] if other in self._by_name]
            found = [*found, *(name for name in queue if included(name))]
        return found

    def _joints(self, controller: ListedController) -> tuple[str, ...]:
        """Return the joints that a controller moves, by itself or through another controller."""
        chained = [interface for name in controller.chained_to if name in self._by_name
                   for interface in self._by_name[name].references]
        return tuple(dict.fromkeys(map(_joint, (*controller.required, *chained))))

    def _absolute(self, name: str) -> str:
        return f'{self.namespace.rstrip("/")}/{name}'


def controllers_to_switch(
    needed: Sequence[str], controllers: Sequence[MoveItControllerSettings], active: Collection[str]
) -> tuple[list[str], list[str]]:
    """
    Return the controllers to activate and to deactivate before a trajectory is sent.

    Active controllers that share joints with the needed ones are deactivated; joints that they
    leave behind get other controllers.

    :param needed: names of the controllers of the trajectory.
    :raises PlanningError: CONTROL_FAILED where a needed controller is not known, or joints would
        be left without a controller.
    """
    joints = {each.name: frozenset(each.joints) for each in controllers}
    for name in needed:
        if name not in joints:
            raise PlanningError(
                MoveItErrorCode.CONTROL_FAILED,
                f"controller '{name}' is gone; known: {', '.join(joints) or 'none'}",
                'trajectory execution')
    starting = [name for name in needed if name not in active]
    stopping = [name for name in joints if name in active and name not in needed
                and any(joints[name] & joints[other] for other in starting)]
    left = frozenset().union(*(joints[name] for name in stopping)) - frozenset().union(
        *(joints[name] for name in starting))
    if left:
        apart = [each for each in controllers
                 if not any(joints[each.name] & joints[name] for name in starting)]
        starting += [each.name for each in select_controllers(
            left, apart, active=active, manages=True)]
    return starting, stopping


def _joint(interface: str) -> str:
    return interface.partition('/')[0]
