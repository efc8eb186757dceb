# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The program replay."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from armsim_ros.errors import extras_hint, ResourceError


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run the actions of a data set again.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 where all episodes go as before, else 1.
    """
    options = _parser().parse_args(sys.argv[1:] if argv is None else argv)
    try:
        from armsim_ros.data.collect import other_versions, replay
    except ModuleNotFoundError as error:
        raise ResourceError(f"the Python package '{error.name}' is not installed: "
                            + extras_hint('gym', 'data')) from None
    for line in other_versions(options.folder):
        print(line)
    same = True
    chosen = None if options.episode is None else [options.episode]
    for episode in replay(options.folder, chosen):
        same &= episode.same
        outcome = 'the same' if episode.same else 'not the same'
        ending = '' if episode.success else ', another ending'
        print(f'episode {episode.number}: {outcome}, states differ by at most '
              f'{episode.deviation:.1e}{ending}', flush=True)
    return 0 if same else 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='replay',
        description='Run the actions of a data set of armsim collect again, and report whether '
                    'states and success are the same.',
        epilog='exit status: 0 the same, 1 not the same, 2 no such data set')
    parser.add_argument('folder', type=Path, metavar='DIR', help='of the data set')
    parser.add_argument('--episode', type=int, metavar='K', help='only this episode')
    return parser
