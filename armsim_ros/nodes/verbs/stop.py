# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim stop``: end every motion, of every client."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Future
import time
from typing import Any

from armsim_ros.clients.motion import EVENT_LATEST, Stopper
from armsim_ros.clients.ros_client import RosClient
from armsim_ros.errors import ArmsimError
from armsim_ros.nodes.verbs.terminal import parser, read, show, until, wait

#: How long no further action may appear until all count as known [s]. Announcements that were lost
#: come again after a second.
_QUIET = 1.2
_PERIOD = 0.02


def main(argv: Sequence[str] | None = None) -> int:
    """
    Stop each action as soon as it is found.

    :returns: 0, or 1 where an action did not answer.
    :raises ArmsimError: there is no action that moves a robot.
    """
    words, ros = read(parser('stop', 'cancel every goal of controllers and move_group'), argv)
    with RosClient('armsim_stop', ros) as client:
        stopper = Stopper(client)
        answers: dict[str, Future[Any]] = {}
        until(stopper.prepare, words.timeout, 'an action that moves')
        start = last = time.monotonic()
        said = False
        while True:
            now = time.monotonic()
            others = [action for action in stopper.prepare() or () if action not in answers]
            found = [action for action in others if stopper.hears(action)]
            for action in found:
                answers[action] = stopper.cancel(action)
                last, said = now, False
            ends = (not others and now - last > _QUIET) or now - start > words.timeout
            # Not between two of them: a goal that it ends first is not counted.
            if not said and (ends or now - last > EVENT_LATEST):
                stopper.send_event()
                said = True
            if ends:
                break
            time.sleep(_PERIOD)
        ended, silent = 0, others
        for name, answer in answers.items():
            try:
                ended += len(wait(answer, 2.0, name).goals_canceling)
            except ArmsimError:
                silent.append(name)
    text = {0: 'no goal is active', 1: '1 goal is being stopped'}.get(
        ended, f'{ended} goals are being stopped')
    if silent:
        text += f"; no answer from {', '.join(silent)}"
    show({'stopped': ended, 'silent': silent}, words.json, text)
    return 1 if silent else 0
