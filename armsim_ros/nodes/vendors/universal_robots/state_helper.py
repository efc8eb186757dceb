# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ur_robot_state_helper/set_mode``: one action from any mode, through a stop, to another."""

from __future__ import annotations

from typing import Any

from rclpy.action import ActionServer
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from ur_dashboard_msgs.action import SetMode
from ur_dashboard_msgs.msg import RobotMode

from armsim_ros.control.safety.arm_state import Mode, Program, Safety
from armsim_ros.errors import SimulationError
from armsim_ros.nodes import qos
from armsim_ros.nodes.vendors.endpoints import ArmNodes
from armsim_ros.nodes.vendors.universal_robots.modes import MODES, robot_mode, safety_mode

TARGETS = {RobotMode.POWER_OFF: Mode.POWER_OFF, RobotMode.IDLE: Mode.IDLE,
           RobotMode.RUNNING: Mode.RUNNING}


class StateHelper:
    """The node ``ur_robot_state_helper``."""

    def __init__(self, nodes: ArmNodes) -> None:
        self._nodes = nodes
        self._arm = nodes.arm
        self.pending = 0
        node = nodes.new_node('ur_robot_state_helper')
        self._server = ActionServer(
            node, SetMode, '~/set_mode', self._execute,
            callback_group=ReentrantCallbackGroup(), **qos.ACTION_SERVICES)

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        self.pending += 1
        try:
            refusal = await self._reach(handle)
        except SimulationError as error:
            refusal = str(error)
        finally:
            self.pending -= 1
        if refusal:
            handle.abort()
        else:
            handle.succeed()
        return SetMode.Result(
            success=not refusal, message=refusal or 'Reached target robot mode.')

    async def _reach(self, handle: ServerGoalHandle) -> str:
        """Bring the arm into the mode of a goal; return why it is not there."""
        goal, arm = handle.request, self._arm
        target = TARGETS.get(goal.target_robot_mode)
        if target is None:
            return (f'the mode {goal.target_robot_mode} cannot be chosen; allowed: '
                    f'{", ".join(map(str, TARGETS))}')
        refusal = str(await self._nodes.change(lambda: self._begin(target, goal.stop_program)))
        shown = (-1, -1)
        while not refusal and arm.mode is not target and not self._nodes.ending:
            now = robot_mode(arm).mode, safety_mode(arm).mode
            if now != shown:
                shown = now
                handle.publish_feedback(SetMode.Feedback(
                    current_robot_mode=now[0], current_safety_mode=now[1]))
            await self._change_of_state()
            if arm.safety not in (Safety.NORMAL, Safety.REDUCED):
                refusal = f'the arm did not reach mode {MODES[target]}: {arm.obstacle}'
        if not refusal and target is Mode.RUNNING and goal.play_program:
            refusal = str(await self._nodes.change(arm.play))
        return refusal or self._nodes.ending

    async def _change_of_state(self) -> None:
        before = self._arm.generation
        await self._nodes.until(lambda: self._arm.generation != before)

    def _begin(self, target: Mode, stop_program: bool) -> str:
        """Clear what stops the arm and start towards the mode; return why that fails."""
        arm = self._arm
        if stop_program and arm.program is not Program.STOPPED:
            arm.stop_program()
        refusal = arm.clear_stop()
        if refusal or arm.mode is target:
            return refusal
        if target is Mode.IDLE and arm.mode is Mode.RUNNING:
            arm.power_to(Mode.POWER_OFF)  # brakes cannot be applied directly
        arm.power_to(target)
        return ''
