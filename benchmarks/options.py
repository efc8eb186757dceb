# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What all benchmarks can be told on the command line."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Options:
    """
    How long and with what to measure.

    :param robot: a name under ``config/`` or a path to a folder.
    :param seconds: of each phase that is watched [s].
    :param minutes: of a long run [min].
    :param runs: repetitions of what is timed as a whole, such as a start.
    :param goals: goals that are sent.
    :param messages: random ones that are sent.
    :param clients: processes that subscribe to everything.
    :param busy: processes that compute beside what is measured.
    :param jogs: of an arm among obstacles.
    :param switches: between kinds of control.
    :param pairs: motions of two arms at once.
    :param edits: of the world and of the planning scene by turns.
    :param problems: folder of planning problems; '' for the packaged ones.
    :param problems_of_a_scene: at most.
    :param peers: planners to run, by how their names begin, with commas between; '' for all.
    :param seed: of the planners.
    :param report: page to put tables and plots into; '' for none.
    """

    robot: str = 'sunday'
    seconds: float = 60.0
    minutes: float = 30.0
    runs: int = 5
    goals: int = 50
    messages: int = 10000
    clients: int = 10
    busy: int = 0
    jogs: int = 1000
    switches: int = 10000
    pairs: int = 500
    edits: int = 1000
    problems: str = ''
    problems_of_a_scene: int = 25
    peers: str = ''
    seed: int = 0
    report: str = ''
