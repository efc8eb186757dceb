# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The process that makes second attempts: requests come in, trajectories go out."""

from __future__ import annotations

from contextlib import suppress
import os
import signal
import time

from armsim_ros.kinematics.kinematic_model import KinematicModel
from armsim_ros.planning.log import silent_log
from armsim_ros.planning.messages import readable, received, send
from armsim_ros.planning.planner import MotionPlanner, warm_up
from armsim_ros.planning.scene import PlanningScene
from armsim_ros.planning.second_attempt import Answer, Job, READY

IDLE = 60.0
"""Time [s] without a job after which the process ends."""

_NICENESS = 5


def main() -> None:
    """Serve until nobody is there any more, or asks."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.nice(_NICENESS)
    incoming, outgoing = 0, os.dup(1)
    os.dup2(2, 1)  # what libraries print must not be taken for an answer
    with suppress(BrokenPipeError):
        serve(incoming, outgoing)


def serve(incoming: int, outgoing: int) -> None:
    """Answer jobs until the end of file, or until none came for a while."""
    scene: PlanningScene | None = None
    planner: MotionPlanner | None = None
    warm_up()
    send(outgoing, READY)
    while readable(incoming, IDLE):
        job = received(incoming)
        if job is None:
            return
        if not isinstance(job, Job):
            continue
        if job.robot is not None:
            scene = PlanningScene(KinematicModel(job.robot))
            planner = MotionPlanner(scene, log=silent_log())
        assert scene is not None
        assert planner is not None
        planner.settings = job.settings
        # Whatever comes next is a reason to stop: another word on this job, or the end.
        response = planner.plan(
            job.request, scene.holding(job.content), clock=time.monotonic,
            cancelled=lambda: readable(incoming))
        send(outgoing, Answer(job.number, response))
