# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Move the arm with Foxglove's protocol, as its panels do.

    pip install websockets mcap-ros2-support
    armsim bringup bridge:=true --ros-args -p foxglove:=control
    python3 bridge_foxglove.py

Reads the joints from their serialized messages, publishes a trajectory to the controller as JSON,
and reads on until the arm has arrived. The first argument is another port.
"""

import json
import struct
import sys
import time

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from websockets.sync.client import connect

STATES = '/sunday/joint_states'
COMMANDS = '/sunday/arm_joint_controller/joint_trajectory'
TARGET, TOLERANCE, PATIENCE = -0.3, 0.01, 30.0
#: Of binary frames, in both directions: a message of a channel.
MESSAGE = 1


def find_channel(connection, topic):
    """Return what the server offers under a name."""
    while True:
        frame = connection.recv(timeout=PATIENCE)
        if isinstance(frame, str):
            for channel in json.loads(frame).get('channels', ()):
                if channel['topic'] == topic:
                    return channel


def joint_states(connection):
    """Yield the positions of the joints as they arrive [rad]."""
    channel = find_channel(connection, STATES)
    decode = DecoderFactory().decoder_for('cdr', Schema(
        id=1, name=channel['schemaName'], encoding=channel['schemaEncoding'],
        data=channel['schema'].encode()))
    connection.send(json.dumps({'op': 'subscribe', 'subscriptions': [
        {'id': 1, 'channelId': channel['id']}]}))
    while True:
        frame = connection.recv(timeout=PATIENCE)
        if isinstance(frame, bytes) and frame[0] == MESSAGE:
            message = decode(frame[13:])  # after operation, subscription and time
            yield dict(zip(message.name, message.position, strict=True))


def main():
    """Move, and return 0 where the arm has arrived."""
    port = int(sys.argv[1]) if len(sys.argv) > 1 else 8765
    with connect(f'ws://127.0.0.1:{port}', subprotocols=['foxglove.sdk.v1'],
                 max_size=None) as connection:
        states = joint_states(connection)
        target = {name: position for name, position in next(states).items()
                  if name.startswith('joint_')}
        target['joint_1'] = TARGET
        connection.send(json.dumps({'op': 'advertise', 'channels': [
            {'id': 1, 'topic': COMMANDS, 'encoding': 'json',
             'schemaName': 'trajectory_msgs/msg/JointTrajectory'}]}))
        for _ in range(50):  # a second, in which the controller finds the publisher
            next(states)
        trajectory = {'joint_names': list(target), 'points': [
            {'positions': list(target.values()), 'time_from_start': {'sec': 2}}]}
        connection.send(struct.pack('<BI', MESSAGE, 1) + json.dumps(trajectory).encode())
        end = time.monotonic() + PATIENCE
        error = TOLERANCE
        while error >= TOLERANCE and time.monotonic() < end:
            error = abs(next(states)['joint_1'] - TARGET)
    print(f'{error * 1e3:.1f} mrad from the target')
    return 0 if error < TOLERANCE else 1


if __name__ == '__main__':
    sys.exit(main())
