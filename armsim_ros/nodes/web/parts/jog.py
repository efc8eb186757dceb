# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Jogging: the tool or a joint moves as long as a button is held, where servo runs."""

from __future__ import annotations

import asyncio
from typing import Any, Literal

from builtin_interfaces.msg import Time
from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.msg import ServoStatus
from moveit_msgs.srv import ServoCommandType
from pydantic import Field

from armsim_ros.clients.description import tip_of
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes import qos
from armsim_ros.nodes.web.page import Page, PanelCommand, Part, Session
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.watch import WatchPart

_TYPE = 'moveit_msgs/srv/ServoCommandType'
_PERIOD = 1.0
#: Period of the commands to servo, and how long the last of the panel holds [s].
_COMMAND_PERIOD, _HOLD = 0.04, 0.5
_FINE = 'No warnings'


class Jog(PanelCommand):
    """
    A command that the panel repeats while a button is held; at the end it sends a share of 0.

    The page repeats it to servo more often, because a browser that draws on the processor may be
    too busy. It stops after ``_HOLD`` if nothing arrives from the panel.
    """

    joint: str = ''
    axis: Literal['', 'x', 'y', 'z', 'rx', 'ry', 'rz'] = ''
    share: float = Field(ge=-1.0, le=1.0)


class JogPart(Part):
    """Sends unitless commands to the first servo that it finds."""

    def __init__(self, page: Page, watch: WatchPart, goals: GoalPart) -> None:
        super().__init__(page)
        self._watch, self._goals = watch, goals
        self._servo = ''
        self._type: int | None = None
        self._publishers: dict[str, Any] = {}
        self._command: Jog
        self._session: Session
        self._jogged_at = 0.0
        self._stream: asyncio.Task[Any] | None = None

    def handlers(self) -> dict[str, Any]:
        """Return what it answers."""
        return {'jog': (Jog, self._jog)}

    async def run(self) -> None:
        """Search for a servo."""
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

    async def _jog(self, session: Session, command: Jog) -> None:
        if not self._servo:
            raise ArmsimError('no servo runs')
        await self._switch(ServoCommandType.Request.JOINT_JOG if command.joint
                           else ServoCommandType.Request.TWIST)
        self._command, self._session = command, session
        self._jogged_at = asyncio.get_running_loop().time()
        if self._stream is None or self._stream.done():
            self._stream = self.page.start(self._follow())

    async def _follow(self) -> None:
        """
        Send the panel's command until it ends, and show servo's warnings; the last one stays.

        Servo publishes a hundred a second to a subscriber, so there is none at other times.
        """
        loop, name = asyncio.get_running_loop(), f'{self._servo}/status'
        status = await asyncio.to_thread(self.page.link.poll, ServoStatus, name, qos.COMMAND)
        try:
            while loop.time() - self._jogged_at < _HOLD and self._publishers:
                self._send(self._session, self._command)
                if not self._command.share:
                    break
                for message in status.take()[-1:]:
                    self.page.publish(
                        'servo_status', '' if message.message == _FINE else message.message)
                await asyncio.sleep(_COMMAND_PERIOD)
        finally:
            status.close()

    def _send(self, session: Session, command: Jog) -> None:
        robot = self.page.robot
        stamp = self._stamp()
        if command.joint:
            message: Any = JointJog(joint_names=[command.joint], velocities=[command.share])
            topic = 'delta_joint_cmds'
        else:
            group = self._goals.goal(session).group
            tip = tip_of(robot.group(group)) if robot is not None and group else ''
            message, topic = TwistStamped(), 'delta_twist_cmds'
            message.header.frame_id = tip or (robot.root_link if robot is not None else '')
            part = message.twist.angular if command.axis.startswith('r') else message.twist.linear
            setattr(part, command.axis[-1:] or 'x', command.share)
        message.header.stamp = stamp
        self.page.link.in_thread(lambda: self._publishers[topic].publish(message))

    async def _switch(self, requested: int) -> None:
        if self._type == requested:
            return
        answer = await self.page.call(
            ServoCommandType, f'{self._servo}/switch_command_type',
            ServoCommandType.Request(command_type=requested))
        if not answer.success:
            raise ArmsimError(f'{self._servo} does not take this kind of command')
        self._type = requested

    def _stamp(self) -> Time:
        """Return the time that servo counts in."""
        now = self._watch.now()
        return Time(sec=int(now), nanosec=int(now % 1.0 * 1e9))
