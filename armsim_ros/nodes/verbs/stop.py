# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim stop``: end every motion, whoever began it."""

from __future__ import annotations

from collections.abc import Sequence

from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.client.ros_client import RosClient
from armsim_ros.nodes.client.stop import Stopper
from armsim_ros.nodes.verbs.terminal import parser, read, show, until, wait


def main(argv: Sequence[str] | None = None) -> int:
    """
    Stop.

    :returns: 0, or 1 where an action did not answer.
    :raises ArmsimError: nothing is there that moves.
    """
    words, ros = read(parser('stop', 'cancel every goal of controllers and move_group'), argv)
    with RosClient('armsim_stop', ros) as client:
        stopper = Stopper(client)
        actions = until(lambda: _reached(stopper), words.timeout, 'an action that moves')
        ended, silent = 0, []
        for name, answer in zip(actions, stopper.stop(), strict=False):
            try:
                ended += len(wait(answer, 2.0, name).goals_canceling)
            except ArmsimError:
                silent.append(name)
    text = f'{ended} goals are being stopped' if ended != 1 else '1 goal is being stopped'
    if silent:
        text += f"; no answer from {', '.join(silent)}"
    show({'stopped': ended, 'silent': silent}, words.json, text)
    return 1 if silent else 0


def _reached(stopper: Stopper) -> list[str] | None:
    """Return the actions that are known by now, None as long as not all of them would hear."""
    stopper.prepare()
    actions = stopper.actions()
    return actions if actions and stopper.ready() else None
