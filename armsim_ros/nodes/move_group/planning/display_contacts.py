# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic ``display_contacts``: where a refused start or goal touches something."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from visualization_msgs.msg import Marker, MarkerArray

from armsim_ros.planning.collision.contacts import Contact

#: Contacts of a state that are shown, the size of a marker [m], and how long RViz keeps it [s].
MOST, SIZE, LIFETIME = 10, 0.02, 30
NAMESPACE = 'contacts'


class DisplayContacts:
    """
    Publishes contacts as spheres; those of the previous plan are deleted first.

    :param topic: '' publishes nothing.
    :param frame: of the contacts: the model frame.
    """

    def __init__(self, node: Node, topic: str, frame: str) -> None:
        self._node, self._frame = node, frame
        self._publisher = node.create_publisher(MarkerArray, topic, 10) if topic else None

    def publish(self, contacts: Sequence[Contact]) -> None:
        """Publish contacts, if anybody subscribes."""
        if self._publisher is None or not self._publisher.get_subscription_count():
            return
        markers = [Marker(action=Marker.DELETEALL)]
        markers += [self._marker(k, contact) for k, contact in enumerate(contacts[:MOST])]
        self._publisher.publish(MarkerArray(markers=markers))

    def _marker(self, number: int, contact: Contact) -> Marker:
        marker = Marker(
            ns=NAMESPACE, id=number, type=Marker.SPHERE, action=Marker.ADD,
            text=f'{contact.body1} {contact.body2}',
        )  # fmt: skip
        marker.header.frame_id = self._frame
        marker.header.stamp = self._node.get_clock().now().to_msg()
        place = marker.pose.position
        place.x, place.y, place.z = map(float, contact.position)
        marker.pose.orientation.w = 1.0
        marker.scale.x = marker.scale.y = marker.scale.z = SIZE
        marker.color.r = marker.color.a = 1.0
        marker.lifetime.sec = LIFETIME
        return marker
