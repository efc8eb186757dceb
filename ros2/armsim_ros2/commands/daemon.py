# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 daemon``: accepted for compatibility."""

from __future__ import annotations

from argparse import Namespace

from armsim_ros2.parsing import flag, Verb


def _status(options: Namespace) -> None:
    print('The daemon is not running')


def _change(options: Namespace) -> None:
    print('No daemon is needed: every command reads the graph itself')


VERBS = {
    'start': Verb('does nothing', _change, [flag('-d', '--debug', about='ignored')]),
    'status': Verb('print that no daemon is running', _status),
    'stop': Verb('does nothing', _change),
}
