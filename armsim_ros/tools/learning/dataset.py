# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program dataset."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.errors import extras_hint, ResourceError


def main(argv: Sequence[str] | None = None) -> int:
    """
    Write a data set of recordings.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0.
    """
    options = _parser().parse_args(sys.argv[1:] if argv is None else argv)
    try:
        from armsim_ros.data.recordings import convert
        from armsim_ros.data.topic_map import topic_map
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: "
                            + extras_hint('gym', 'data')) from None
    *recordings, folder = options.paths
    if not recordings:
        _parser().error('name at least one recording and the folder of the data set')
    data = convert(recordings, folder, topic_map(options.map), allow_gaps=options.allow_gaps)
    print(f'{data.episodes} episodes, {data.frames} frames')
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='dataset',
        description='Write recordings of topics (MCAP, as of rosbag2) as a data set in the '
                    'layout v3.0 of LeRobot.',
        epilog='exit status: 0, or 2 where recordings and map do not fit')
    parser.add_argument('paths', type=Path, nargs='+', metavar='RECORDING ... DIR',
                        help='MCAP files, then the folder of the data set')
    parser.add_argument('--map', type=Path, required=True, metavar='FILE',
                        help='YAML file: which topics become which features')
    parser.add_argument('--allow-gaps', action='store_true',
                        help='keep the last value of topics that are silent')
    return parser
