# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Topics and services of grippers: ``contacts`` of fingers; ``on``, ``off``, ``grasping``."""

from __future__ import annotations

from collections.abc import Callable
import re
from typing import Any

from moveit_msgs.msg import ContactInformation
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import Bool
from std_srvs.srv import Empty

from armsim_ros.errors import SimulationError
from armsim_ros.model.grippers import Gripper
from armsim_ros.nodes import qos
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.nodes.simulation.world.answers import Work
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.finger_contacts import FingerContact, FingerContacts
from armsim_ros.sim.vacuum_control import VacuumControl
from armsim_ros.sim.vacuum_gripper import VacuumGripper
from armsim_ros.sim.world.entities import WORLD_FRAME

#: Simulated time between two looks [ns].
PERIOD_NS = 20_000_000
DEPTH = 100


class GripperContacts:
    """
    Publishes a message for each point of contact, and none where there is none.

    :param namespace: of the robot, with a slash before it.
    :param gripper: whose fingers.
    :param fingers: reads their contacts.
    """

    def __init__(
        self, node: Node, loop: ControlLoop, dispatcher: Dispatcher, namespace: str,
        gripper: Gripper, fingers: FingerContacts
    ) -> None:
        self._loop, self._gripper, self._fingers = loop, gripper, fingers
        self._looking = False
        self._post = dispatcher.bounded()
        name = re.sub(r'\W', '_', gripper.name)
        self._publisher = node.create_publisher(
            ContactInformation, f'{namespace}/{name}/contacts', QoSProfile(depth=DEPTH),
            event_callbacks=PublisherEventCallbacks(matched=self._match))

    def _match(self, _: Any) -> None:
        self._loop.call(self._look_where_wanted)

    def _look_where_wanted(self) -> None:
        """Start or stop watching the fingers; in the loop's thread."""
        requested = self._publisher.get_subscription_count() > 0
        if requested != self._looking:
            self._looking = requested
            if requested:
                self._loop.every(PERIOD_NS, self._look)
            else:
                self._loop.forget(self._look)

    def _look(self, time_ns: int) -> None:
        found = self._fingers.contacts(self._gripper)
        if found:
            self._post(lambda: self._publish(time_ns, found))

    def _publish(self, time_ns: int, found: list[FingerContact]) -> None:
        for contact in found:
            self._publisher.publish(_message(time_ns, contact))


def _message(time_ns: int, contact: FingerContact) -> ContactInformation:
    message = ContactInformation(
        depth=contact.depth,
        contact_body_1=contact.link,
        body_type_1=ContactInformation.ROBOT_LINK,
        contact_body_2=contact.other,
        body_type_2=(ContactInformation.WORLD_OBJECT if contact.is_object
                     else ContactInformation.ROBOT_LINK))
    message.header.frame_id = WORLD_FRAME
    fill_time(message.header.stamp, time_ns)
    for field, values in ((message.position, contact.position), (message.normal, contact.normal)):
        field.x, field.y, field.z = (float(value) for value in values)
    return message


#: Wall time between two messages about whether something is held [s].
_PERIOD = 0.1


class VacuumGripperServer:
    """
    Switches a suction cup and publishes whether it holds something.

    :param namespace: of the robot, with a slash before it.
    :param tell_scene: publishes the present world to planning, and then calls back.
    """

    def __init__(
        self, node: Node, work: Work, dispatcher: Dispatcher, namespace: str,
        gripper: VacuumGripper, tell_scene: Callable[[Callable[[], object]], object]
    ) -> None:
        self._node, self._work, self._gripper = node, work, gripper
        self.control = VacuumControl(
            work.loop, gripper, lambda: dispatcher.post(lambda: tell_scene(self._notice)))
        # In a cell the name begins with the namespace.
        own = gripper.name.removeprefix(f'{namespace.strip("/")}/')
        place = f'{namespace}/{own}'
        group = ReentrantCallbackGroup()
        for name, answer in (('on', self._on), ('off', self._off)):
            node.create_service(Empty, f'{place}/{name}', answer, callback_group=group)
        self._publisher = node.create_publisher(Bool, f'{place}/grasping', qos.LATCHED)
        self._grasping = False
        self._publish()
        dispatcher.every(_PERIOD, self._look)

    async def _on(self, _: Any, response: Any) -> Any:
        await self._switched(self.control.on)
        return response

    async def _off(self, _: Any, response: Any) -> Any:
        await self._switched(self.control.off)
        return response

    async def _switched(self, switch: Any) -> None:
        try:
            await self._work.in_loop(switch)
        except SimulationError as error:
            self._node.get_logger().error(f"gripper '{self._gripper.name}': {error}")

    def _look(self) -> None:
        while self._gripper.losses:
            self._node.get_logger().warning(self._gripper.losses.popleft())
        if self._publisher.get_subscription_count():
            self._publish()

    def _notice(self) -> None:
        self._grasping = bool(self._gripper.held)
        self._publish()

    def _publish(self) -> None:
        self._publisher.publish(Bool(data=self._grasping))
