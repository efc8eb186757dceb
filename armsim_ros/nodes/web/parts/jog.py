# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Jogging: the tool or a joint moves as long as a button is held, where servo runs."""

from __future__ import annotations

from typing import Any, Literal

from builtin_interfaces.msg import Time
from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.srv import ServoCommandType
from pydantic import Field

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.client.description import tip_of
from armsim_ros.nodes.web.page import Ask, Page, Part
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.nodes.web.visitor import Visitor

_TYPE = 'moveit_msgs/srv/ServoCommandType'
_PERIOD = 1.0


class Jog(Ask):
    """
    A command of a moment; a button that is held sends one after the other.

    Servo stops by itself when none comes any more, so a lost connection stops too.
    """

    joint: str = ''
    axis: Literal['', 'x', 'y', 'z', 'rx', 'ry', 'rz'] = ''
    share: float = Field(ge=-1.0, le=1.0)


class JogPart(Part):
    """
    Sends unitless commands to the first servo that it finds.

    :param watch: who knows what is served.
    :param goals: which group's tip moves.
    """

    def __init__(self, page: Page, watch: WatchPart, goals: GoalPart) -> None:
        super().__init__(page)
        self._watch, self._goals = watch, goals
        self._servo = ''
        self._type: int | None = None
        self._publishers: dict[str, Any] = {}

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'jog': (Jog, self._jog)}

    async def run(self) -> None:
        """Look for a servo."""
        while True:
            found = sorted(name.removesuffix('/switch_command_type') for name, kind in
                           self._watch.services.items()
                           if kind == _TYPE and name.endswith('/switch_command_type'))
            servo = found[0] if found else ''
            if servo != self._servo:
                self._servo, self._type, self._publishers = servo, None, {}
                if servo:
                    self.page.link.prepare(ServoCommandType, f'{servo}/switch_command_type')
                    await self.page.answer(self.page.link.in_thread(self._make_publishers))
            self.page.publish('servo', servo)
            await self._watch.rest(_PERIOD)

    def _make_publishers(self) -> None:
        node = self.page.link.node
        for name, kind in (('delta_twist_cmds', TwistStamped), ('delta_joint_cmds', JointJog)):
            self._publishers[name] = node.create_publisher(kind, f'{self._servo}/{name}', 10)

    async def _jog(self, visitor: Visitor, ask: Jog) -> None:
        if not self._servo:
            raise ArmsimError('no servo runs')
        await self._switch(ServoCommandType.Request.JOINT_JOG if ask.joint
                           else ServoCommandType.Request.TWIST)
        robot = self.page.robot
        stamp = self._stamp()
        if ask.joint:
            command: Any = JointJog(joint_names=[ask.joint], velocities=[ask.share])
            topic = 'delta_joint_cmds'
        else:
            group = self._goals.goal(visitor).group
            tip = tip_of(robot.group(group)) if robot is not None and group else ''
            command, topic = TwistStamped(), 'delta_twist_cmds'
            command.header.frame_id = tip or (robot.root_link if robot is not None else '')
            part = command.twist.angular if ask.axis.startswith('r') else command.twist.linear
            setattr(part, ask.axis[-1:] or 'x', ask.share)
        command.header.stamp = stamp
        self.page.link.in_thread(lambda: self._publishers[topic].publish(command))

    async def _switch(self, wanted: int) -> None:
        if self._type == wanted:
            return
        answer = await self.page.call(
            ServoCommandType, f'{self._servo}/switch_command_type',
            ServoCommandType.Request(command_type=wanted))
        if not answer.success:
            raise ArmsimError(f'{self._servo} does not take this kind of command')
        self._type = wanted

    def _stamp(self) -> Time:
        """Return the time that servo counts in."""
        now = self._watch.now()
        return Time(sec=int(now), nanosec=int(now % 1.0 * 1e9))
