# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``<ns>/<gripper>/contacts``: where fingers touch, while there are subscribers."""

from __future__ import annotations

import re
from typing import Any

from moveit_msgs.msg import ContactInformation
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

from armsim_ros.model.grippers import Gripper
from armsim_ros.nodes.conversions.time import fill_time
from armsim_ros.nodes.simulation.dispatcher import Dispatcher
from armsim_ros.sim.control_loop import ControlLoop
from armsim_ros.sim.grippers.finger_contacts import FingerContact, FingerContacts
from armsim_ros.sim.world.entities import WORLD_FRAME

#: Simulated time between two looks [ns].
PERIOD_NS = 20_000_000
DEPTH = 100


class GripperContacts:
    """
    Publishes a message for each point of contact, and none where there is none.

    :param node: the node that publishes.
    :param namespace: of the robot, with a slash before it.
    :param gripper: whose fingers.
    :param fingers: reads their contacts.
    """

    def __init__(
        self,
        node: Node,
        loop: ControlLoop,
        dispatcher: Dispatcher,
        namespace: str,
        gripper: Gripper,
        fingers: FingerContacts,
    ) -> None:
        self._loop, self._gripper, self._fingers = loop, gripper, fingers
        self._looking = False
        self._post = dispatcher.bounded()
        name = re.sub(r'\W', '_', gripper.name)
        self._publisher = node.create_publisher(
            ContactInformation, f'{namespace}/{name}/contacts', QoSProfile(depth=DEPTH),
            event_callbacks=PublisherEventCallbacks(
                matched=self._match),
        )

    def _match(self, _: Any) -> None:
        self._loop.call(self._look_where_wanted)

    def _look_where_wanted(self) -> None:
        """Start or stop watching the fingers; in the loop's thread."""
        wanted = self._publisher.get_subscription_count() > 0
        if wanted != self._looking:
            self._looking = wanted
            if wanted:
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
                     else ContactInformation.ROBOT_LINK),
    )
    message.header.frame_id = WORLD_FRAME
    fill_time(message.header.stamp, time_ns)
    for field, values in ((message.position, contact.position), (message.normal, contact.normal)):
        field.x, field.y, field.z = (float(value) for value in values)
    return message
