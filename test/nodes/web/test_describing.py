# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The robot is drawn while what is known of it still changes."""

import threading

import pytest

pytest.importorskip('viser')

from armsim_ros.clients.ros_client import RosClient
from armsim_ros.nodes.web.main import WebArguments
from armsim_ros.nodes.web.page import Page
from armsim_ros.nodes.web.parts import robot
from armsim_ros.nodes.web.program import page_parts

#: For what happens in the page's own time, and for what must not happen [s].
PATIENCE, GRACE = 30.0, 1.0


@pytest.fixture
def link(fake_stack):
    """Join the graph of a stack that runs."""
    with RosClient('web') as link:
        yield link


def test_news_of_move_group_do_not_disturb_a_drawing(link, monkeypatch):
    """A drawing that takes its time is the only one, and the robot is told at its end."""
    begun, twice, told = threading.Event(), threading.Event(), threading.Event()

    class SlowDrawing(robot.RobotDrawing):
        def __init__(self, *words):
            if begun.is_set():
                twice.set()
            begun.set()
            twice.wait(GRACE)
            super().__init__(*words)

    monkeypatch.setattr(robot, 'RobotDrawing', SlowDrawing)
    page = Page(link)
    monkeypatch.setattr(page, 'take_robot', lambda _: told.set())
    page.open('127.0.0.1', 8470, '', lambda page: page_parts(page, WebArguments()))
    try:
        assert begun.wait(PATIENCE)
        page.soon(lambda: page.take_program('move_group', True))
        assert told.wait(PATIENCE)
        assert not twice.is_set()
    finally:
        page.close()
