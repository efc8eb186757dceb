# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim state``: joint positions, controllers, named states, and whether time passes."""

from __future__ import annotations

from collections.abc import Sequence
import math
import time
from typing import Any
from xml.etree import ElementTree

from controller_manager_msgs.srv import ListControllers
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.clients.simulated_time import PAUSED, SimulatedTime
from armsim_ros.nodes import qos
from armsim_ros.nodes.verbs.terminal import call, parser, PATIENCE, read, show, table, until

_TYPE = 'sensor_msgs/msg/JointState'
_MANAGER = '/list_controllers'
SRDF = '/robot_description_semantic'
#: Joint states that are published at all come sooner [s].
_SILENCE = 0.5


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print the state of every robot that is there.

    :returns: 0.
    :raises ArmsimError: no joint states arrive.
    """
    words, ros = read(parser('state', 'print joint positions, controllers and named states'), argv)
    with RosClient('armsim_state', ros) as client:
        simulated = SimulatedTime(client)
        joints = joint_states(client, words.timeout, simulated)
        controllers = active_controllers(client, words.timeout)
        states = named_states(client)
        paused = simulated.paused()
    value = {'joints': joints, 'controllers': controllers, 'states': states, 'paused': paused}
    rows = [['joint', 'position', '', 'velocity']]
    for each in joints:
        angle = f"({math.degrees(each['position']):.1f}°)"
        rows.append([each['name'], f"{each['position']:.4f}", angle, f"{each['velocity']:.4f}"])
    rows.append(['', '', '', ''])
    text = '\n'.join([table(rows), table([
        ['controller', 'state', 'type'],
        *([each['name'], each['state'], each['type']] for each in controllers)])])
    text += ''.join(f"\n\nnamed states of '{group}': {', '.join(names)}"
                    for group, names in states.items())
    if paused:
        text += f'\n\n{PAUSED}'
    show(value, words.json, text)
    return 0


def joint_states(client: RosClient, patience: float, simulated: SimulatedTime
                 ) -> list[dict[str, Any]]:
    """
    Return name, position [rad or m] and velocity of every joint.

    :param simulated: publishes them where time does not pass.
    :raises ArmsimError: no message comes in time.
    """
    topics: dict[str, Any] = {}
    found: dict[str, dict[str, Any]] = {}
    due = time.monotonic() + _SILENCE

    def look() -> bool | None:
        for name, kinds in client.node.get_topic_names_and_types():
            if kinds[0] == _TYPE and name not in topics and client.node.count_publishers(name):
                topics[name] = client.poll(JointState, name, qos.COMMAND)
        heard = 0
        for topic in list(topics.values()):
            for message in topic.take():
                heard += 1
                for index, joint in enumerate(message.name):
                    velocity = message.velocity[index] if message.velocity else math.nan
                    found[joint] = {'name': joint, 'position': float(message.position[index]),
                                    'velocity': float(velocity)}
        nonlocal due
        if topics and not heard and time.monotonic() > due:
            simulated.publish_now()
            due = time.monotonic() + _SILENCE
        return True if heard and heard >= len(topics) else None

    until(look, patience, 'a topic with joint states')
    return list(found.values())


def named_states(client: RosClient) -> dict[str, list[str]]:
    """Return group -> names of its states, from the SRDF; none where no SRDF is published."""
    if not client.node.count_publishers(SRDF):
        return {}
    topic = client.poll(String, SRDF, qos.DESCRIPTION)
    message, = until(lambda: topic.take()[-1:] or None, PATIENCE, SRDF)
    states: dict[str, list[str]] = {}
    for state in ElementTree.fromstring(message.data).findall('group_state'):
        states.setdefault(state.get('group', ''), []).append(state.get('name', ''))
    return states


def active_controllers(client: RosClient, patience: float) -> list[dict[str, Any]]:
    """Return the controllers of every controller manager, with their full names."""
    names = [name for name, _ in client.node.get_service_names_and_types()
             if name.endswith(_MANAGER)]
    found = []
    for name in sorted(names):
        space = name.removesuffix(_MANAGER).rpartition('/')[0]
        for each in call(client, ListControllers, name, None, patience).controller:
            found.append({'name': f'{space}/{each.name}', 'state': each.state, 'type': each.type})
    return found
