# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""tf2_monitor of tf2_ros: prints the delays of all frames, or of those between two frames."""

from __future__ import annotations

from collections.abc import Sequence
import sys

from builtin_interfaces.msg import Time
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
import rclpy.logging
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from tf2_msgs.msg import TFMessage
from tf2_ros import TransformException

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.nodes.upstream.awaited_transform import AwaitedTransform, LATEST
from armsim_ros.nodes.upstream.single_node import spin
from armsim_ros.nodes.upstream.transform_delays import TransformDelays

_NODE = 'tf2_monitor_main'
_WRONG_WORDS = 255
#: How often the transform is looked up [s], and how often before results are printed.
_PERIOD, _LOOKUPS = 0.5, 21
#: Weight of a new value in the average delay of the transform.
_LOWPASS = 0.01


def main(argv: Sequence[str] | None = None) -> int:
    """
    Print delays until SIGINT or SIGTERM.

    :returns: 0 after a signal, 255 for a wrong number of words.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    if len(words) not in (0, 2):
        rclpy.logging.get_logger(_NODE).info('TF_Monitor: usage: tf2_monitor framea frameb')
        return _WRONG_WORDS
    return spin(_NODE, ros_args, lambda node: _Monitor(node, words))


class _Monitor:
    """
    Gathers delays and prints them every ten seconds.

    :param frames: the two between which delays are gathered; none for all frames.
    """

    def __init__(self, node: Node, frames: Sequence[str]) -> None:
        self._node, self._frames = node, frames
        self._delays = TransformDelays()
        self._net_delay = self._largest_net_delay = 0.0
        self._lookups = 0
        self._chain: list[str] | None = None
        self._transform = AwaitedTransform(node, *frames) if frames else None
        self._gathers = False
        self._timer = node.create_timer(
            _PERIOD, self._step, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self._step()

    def _step(self) -> None:
        if not self._gathers:
            if self._transform is not None and not self._transform.available():
                return
            self._gather()
        if self._lookups == _LOOKUPS:
            self._lookups = 0
            self._print_results()
        self._lookups += 1
        self._look_up()

    def _gather(self) -> None:
        self._gathers = True
        if self._transform is not None:
            target, source = self._frames
            self._chain = self._transform.buffer._chain(source, LATEST, target, LATEST, source)
        for topic, durability in (('/tf', DurabilityPolicy.VOLATILE),
                                  ('/tf_static', DurabilityPolicy.TRANSIENT_LOCAL)):
            self._node.create_subscription(
                TFMessage, topic, self._add, QoSProfile(depth=100, durability=durability))
        what = ' -> '.join(self._frames) or 'all frames'
        print(f'Gathering data on {what} for 10 seconds...', flush=True)

    def _add(self, message: TFMessage) -> None:
        self._delays.add(((each.child_frame_id, _seconds(each.header.stamp))
                          for each in message.transforms), self._now())

    def _look_up(self) -> None:
        if self._transform is None:
            return
        try:
            stamp = self._transform.look_up().header.stamp
        except TransformException as error:
            self._node.get_logger().warning(f'Transform Exception {error}')
            return
        delay = self._now() - _seconds(stamp)
        self._net_delay += _LOWPASS * (delay - self._net_delay)
        self._largest_net_delay = max(self._largest_net_delay, delay)

    def _print_results(self) -> None:
        head = ['RESULTS: for all Frames']
        if self._chain is not None:
            head = [f"RESULTS: for {' to '.join(self._frames)}",
                    f"Chain is: {' -> '.join(self._chain)}",
                    f'Net delay     avg = {self._net_delay:g}: max = {self._largest_net_delay:g}']
        print('\n\n', *head, '', 'Frames:', *self._delays.frame_lines(self._chain), sep='\n',
              flush=True)
        print('\nAll Broadcasters:', file=sys.stderr, flush=True)
        for line in self._delays.broadcaster_lines():
            print(line, flush=True)

    def _now(self) -> float:
        return float(self._node.get_clock().now().nanoseconds * 1e-9)


def _seconds(stamp: Time) -> float:
    return float(stamp.sec + stamp.nanosec * 1e-9)
