# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page's program from start to end."""

from __future__ import annotations

from collections.abc import Iterator
import os
import secrets
import sys
import threading

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.nodes.ports import is_loopback
from armsim_ros.nodes.web.main import WebArguments
from armsim_ros.nodes.web.page import Page, Part
from armsim_ros.nodes.web.parts.controllers import ControllersPart, SafetyPart
from armsim_ros.nodes.web.parts.goal import GoalPart
from armsim_ros.nodes.web.parts.jog import JogPart
from armsim_ros.nodes.web.parts.motion import MotionPart
from armsim_ros.nodes.web.parts.objects import ObjectsPart
from armsim_ros.nodes.web.parts.octomap import OctomapPart
from armsim_ros.nodes.web.parts.path import PathPart
from armsim_ros.nodes.web.parts.robot import RobotPart
from armsim_ros.nodes.web.parts.simulation import SimulationPart
from armsim_ros.nodes.web.parts.watch import WatchPart
from armsim_ros.packages import Packages


class WebProgram:
    """The link to the graph and the page."""

    def __init__(self, arguments: WebArguments) -> None:
        self._arguments = arguments

    def run(self, ended: threading.Event) -> int:
        """
        Serve until the event is set.

        :returns: the exit status.
        :raises ServingError: the page cannot be served at this address.
        """
        arguments = self._arguments
        token = arguments.token
        if not token and not is_loopback(arguments.host):
            token = secrets.token_urlsafe(24)
        with RosClient('web', arguments.ros_args) as link:
            page = Page(link)
            page.open(arguments.host, arguments.port, token,
                      lambda page: page_parts(page, arguments))
            print(f'page: {page.server.address}', flush=True)
            ended.wait()
            page.halt()
        sys.stdout.flush()
        # viser's threads would be waited for; nothing of them has to be kept.
        os._exit(0)


def page_parts(page: Page, arguments: WebArguments) -> Iterator[Part]:
    """Return all that the page does."""
    robot = RobotPart(page, Packages(arguments.packages_path, near=arguments.near))
    watch = WatchPart(page)
    goals = GoalPart(page, robot)
    paths = PathPart(page, robot, goals)
    yield from (
        robot, watch, goals, paths, MotionPart(page, watch, goals, paths),
        ObjectsPart(page, robot, goals), OctomapPart(page, watch, robot),
        ControllersPart(page, watch), SafetyPart(page, watch),
        SimulationPart(page, watch, robot),
        JogPart(page, watch, goals))
