# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""view_frames of tf2_tools: draws the tree of frames."""

from __future__ import annotations

from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from pathlib import Path
import signal
import subprocess
import sys
import time

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from tf2_msgs.srv import FrameGraph
from tf2_ros import Buffer, TransformListener
import yaml

from armsim_ros.cli.arguments import split_ros_args
from armsim_ros.nodes.upstream.single_node import spin

_FAILED, _INTERRUPTED = 1, 128 + signal.SIGINT
#: What a frame's label has -> the key of the buffer's YAML.
_NUMBERS = {'Average rate': 'rate', 'Buffer length': 'buffer_length',
            'Most recent transform': 'most_recent_transform',
            'Oldest transform': 'oldest_transform'}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Listen to the transforms for a while and draw the tree.

    :returns: 0 when the .gv file is written, 1 where that is impossible, 130 after a signal.
    """
    words, ros_args = split_ros_args(sys.argv[1:] if argv is None else argv)
    parser = ArgumentParser(
        prog='view_frames',
        description='Create a diagram of the TF frames being broadcast over ROS')
    parser.add_argument(
        '--wait-time', '-t', type=float, default=5.0,
        help='Listen to the /tf topic for this many seconds before rendering the frame tree')
    parser.add_argument('-o', '--output', help='Output filename')
    options = parser.parse_args(words)
    name = options.output
    if name is None:
        name = time.strftime('frames_%Y-%m-%d_%H.%M.%S')
    statuses: list[int] = []

    def make(node: Node) -> object:
        buffer = Buffer(node=node)
        listener = TransformListener(buffer, node)
        node.get_logger().info(f'Listening to tf data for {options.wait_time} seconds...')

        def end() -> None:
            statuses.append(_export(node, buffer.all_frames_as_yaml(), name))
            rclpy.try_shutdown()

        timer = node.create_timer(
            max(0.0, options.wait_time), end, clock=Clock(clock_type=ClockType.STEADY_TIME))
        return listener, timer

    spin('view_frames', ros_args, make)
    return statuses[0] if statuses else _INTERRUPTED


def _export(node: Node, frames: str, name: str) -> int:
    """Write the graph of the buffer's YAML and return the exit status."""
    logger = node.get_logger()
    logger.info('Generating graph...')
    logger.info(f'Result:{FrameGraph.Response(frame_yaml=frames)}')
    graph, drawing = f'{name}.gv', f'{name}.pdf'
    logger.info(f'Exporting graph in {drawing} file...')
    # Every text stays as it is: a frame may be named 1 or on.
    read = yaml.load(frames, yaml.BaseLoader) or {}
    now = node.get_clock().now().nanoseconds * 1e-9
    try:
        Path(graph).write_text(format_graph(read, now), encoding='utf-8')
    except OSError as error:
        logger.error(f'cannot write {graph}: {error.strerror}')
        return _FAILED
    command = ['dot', '-Tpdf', graph, '-o', drawing]
    try:
        subprocess.run(command, check=False)
    except FileNotFoundError:
        logger.warning(f'{drawing} is not written, because Graphviz is not installed; install it '
                       f"(apt install graphviz), then: {' '.join(command)}")
    return 0


def format_graph(frames: Mapping[str, Mapping[str, str]], now: float) -> str:
    """
    Return the tree in Graphviz's language.

    :param frames: what the buffer has of each frame with a parent, all in texts.
    :param now: [s].
    """
    if not frames:
        return 'digraph G { "No tf data received" }'
    lines = ['digraph G {']
    for name, frame in frames.items():
        numbers = ''.join(f'{label}: {float(frame[key])}\\n' for label, key in _NUMBERS.items())
        lines.append(f'"{frame["parent"]}" -> "{name}"'
                     f'[label=" Broadcaster: {frame["broadcaster"]}\\n{numbers}"];')
    roots = [frame['parent'] for frame in frames.values() if frame['parent'] not in frames]
    lines += ['edge [style=invis];',
              ' subgraph cluster_legend { style=bold; color=black; label ="view_frames Result";',
              f'"Recorded at time: {now}"[ shape=plaintext ] ;',
              # Frames in a loop have no root.
              f'}}->"{roots[-1]}";' if roots else '}', '}']
    return '\n'.join(lines)
