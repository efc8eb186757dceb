# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Jog the arm with the keyboard.

    armsim bringup servo:=true
    armsim go ready                # in a second terminal; home is a singularity
    python examples/jog.py

w s  a d  q e   move the tip along x, y, z of the base, forwards and backwards
1 to 9          turn that joint; r reverses the direction
space           stop
Ctrl-C          leave
"""

import argparse
import os
import select
import signal
import sys
import termios
import time
import tty

from control_msgs.msg import JointJog
from geometry_msgs.msg import TwistStamped
from moveit_msgs.msg import ServoStatus
from moveit_msgs.srv import ServoCommandType
import rclpy
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

MOVES = {'w': (1, 0, 0), 's': (-1, 0, 0), 'a': (0, 1, 0), 'd': (0, -1, 0),
         'q': (0, 0, 1), 'e': (0, 0, -1)}
RATE = 50.0
HELD = 0.25
"""A key counts as held for so long: terminals repeat a held key more often than that [s]."""


class Jogger:
    """Publishes the command of the pressed key."""

    def __init__(self, node, frame, joint_states):
        self.node = node
        self.frame = frame
        self.twists = node.create_publisher(TwistStamped, '/servo_node/delta_twist_cmds', 10)
        self.jogs = node.create_publisher(JointJog, '/servo_node/delta_joint_cmds', 10)
        self.types = node.create_client(ServoCommandType, '/servo_node/switch_command_type')
        self.type = None
        self.ask_again = 0.0
        self.joints = []
        self.shown = ''
        self.direction = 1.0
        node.create_subscription(ServoStatus, '/servo_node/status', self.status, 1)
        node.create_subscription(JointState, joint_states, self.names, 1)

    def status(self, message):
        """Show a status that is new, from the first key on."""
        if self.type is None:
            return
        text = '' if message.message == 'No warnings' else message.message
        if text != self.shown:
            self.shown = text
            print(f'\r\x1b[K{text}', end='', flush=True)

    def names(self, message):
        """Remember the joints, in the order of their names."""
        self.joints = sorted(message.name)

    def choose(self, kind):
        """Have servo follow a type of commands; repeat the request where no answer comes."""
        now = time.monotonic()
        if kind == self.type or now < self.ask_again:
            return
        self.ask_again = now + 1.0
        answer = self.types.call_async(ServoCommandType.Request(command_type=kind))
        answer.add_done_callback(lambda done: self.chosen(kind, done.result().success))

    def chosen(self, kind, success):
        """Remember which type servo follows."""
        self.ask_again = 0.0
        if success:
            self.type = kind

    def press(self, key):
        """Send one command for a key."""
        stamp = self.node.get_clock().now().to_msg()
        if key in MOVES:
            self.choose(ServoCommandType.Request.TWIST)
            twist = TwistStamped()
            twist.header.stamp, twist.header.frame_id = stamp, self.frame
            linear = twist.twist.linear
            linear.x, linear.y, linear.z = map(float, MOVES[key])
            self.twists.publish(twist)
        elif key.isdigit() and 0 < int(key) <= len(self.joints):
            self.choose(ServoCommandType.Request.JOINT_JOG)
            jog = JointJog(joint_names=[self.joints[int(key) - 1]], velocities=[self.direction])
            jog.header.stamp = stamp
            self.jogs.publish(jog)


def main():
    """Read keys and jog."""
    parser = argparse.ArgumentParser(description='Jog the arm with the keyboard.')
    parser.add_argument('--frame', default='base_link', help='whose axes the letters mean')
    parser.add_argument('--joint-states', default='/sunday/joint_states')
    arguments = parser.parse_args()
    if not sys.stdin.isatty():
        sys.exit('jog: keys are read from a terminal; start it in a terminal')
    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node('jog')
    jogger = Jogger(node, arguments.frame, arguments.joint_states)
    if not jogger.types.wait_for_service(10.0):
        sys.exit('jog: there is no servo_node; start bringup with servo:=true')
    simulated = False
    print(__doc__.partition('jog.py')[2])
    before = termios.tcgetattr(sys.stdin)
    key, pressed = '', 0.0
    ended = []
    signal.signal(signal.SIGINT, lambda *_: ended.append(True))
    try:
        tty.setcbreak(sys.stdin)
        while not ended:
            for _ in range(10):  # all that has come since
                rclpy.spin_once(node, timeout_sec=0.0)
            if not simulated and node.count_publishers('/clock'):
                # Where time is simulated, commands bear that time: servo drops what is old.
                simulated = True
                node.set_parameters([Parameter('use_sim_time', value=True)])
            now = time.monotonic()
            if select.select([sys.stdin], [], [], 1.0 / RATE)[0]:
                # All keys at once: those of a moment ago must not move anything later.
                keys, pressed = os.read(sys.stdin.fileno(), 1000).decode(errors='replace'), now
                key = keys[-1:]
                if keys.count('r') % 2:
                    jogger.direction = -jogger.direction
            elif now - pressed > HELD:
                key = ''
            if key:
                jogger.press(key)
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)
        rclpy.shutdown()


if __name__ == '__main__':
    main()
