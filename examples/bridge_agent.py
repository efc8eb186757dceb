# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Move the arm with the tools of ros-mcp, as a language model does.

    pip install ros-mcp
    armsim bringup bridge:=true
    python examples/bridge_agent.py

An agent chooses the tools; this program makes the calls that an agent would make. The first
argument is another port.
"""

import asyncio
import json
import shutil
import sys

from mcp import ClientSession, StdioServerParameters
from mcp.client.stdio import stdio_client

STATES, CONTROLLER = '/sunday/joint_states', '/sunday/arm_joint_controller/follow_joint_trajectory'
TYPE = 'control_msgs/action/FollowJointTrajectory'
TARGET = -0.4


async def use(session, tool, **arguments):
    """Call a tool and return its answer."""
    answer = await session.call_tool(tool, arguments)
    text = next(item.text for item in answer.content if item.type == 'text')
    found = json.loads(text)
    print(f'{tool}: {text[:100]}')
    assert 'error' not in found, text
    return found


async def position(session):
    """Return names and positions of the joints [rad]."""
    found = await use(session, 'subscribe_once', topic=STATES, msg_type='sensor_msgs/JointState')
    message = found.get('msg', found)
    return dict(zip(message['name'], message['position'], strict=False))


async def main():
    """Connect, explore, move, and return 0 where the arm has arrived."""
    port = int(sys.argv[1]) if len(sys.argv) > 1 else 9090
    program = shutil.which('ros-mcp') or 'ros-mcp'
    server = StdioServerParameters(command=program, args=['--transport=stdio'])
    async with stdio_client(server) as streams, ClientSession(*streams) as session:
        await session.initialize()
        await use(session, 'connect_to_robot', ip='127.0.0.1', port=port)
        await use(session, 'get_topics')
        await use(session, 'get_actions')
        await use(session, 'get_action_details', action=CONTROLLER, action_type=TYPE)
        await use(session, 'get_parameter', name='/move_group:use_sim_time')
        joints = {name: value for name, value in (await position(session)).items()
                  if name.startswith('joint_')}
        joints['joint_1'] = TARGET
        goal = {'trajectory': {'joint_names': list(joints), 'points': [
            {'positions': list(joints.values()), 'time_from_start': {'sec': 2, 'nanosec': 0}}]}}
        await use(session, 'send_action_goal', action_name=CONTROLLER, goal=goal,
                  action_type=TYPE, timeout=20.0)
        await use(session, 'get_action_status', action_name=CONTROLLER)
        error = abs((await position(session))['joint_1'] - TARGET)
    print(f'{error * 1e3:.1f} mrad from the target')
    return 0 if error < 0.01 else 1


if __name__ == '__main__':
    sys.exit(asyncio.run(main()))
