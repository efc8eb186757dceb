# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures while a client moves time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from sensor_msgs.msg import Image
from world_user import OK, WorldUser

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.nodes.conversions.time import ns_from_time
from armsim_ros.testing.program import private_domain, start_program

statement = pytest.mark.statement
PATIENCE = 120.0
PERIOD_NS = 100_000_000
STATE = 2
BALL = 'armsim://sphere?radius=0.05&mass=0.2&color=1,0,0'


@pytest.fixture
def lockstep(drawing: None) -> Iterator[WorldUser]:
    """Start a simulation in lockstep, and what draws."""
    words = ('world:=feeding_place', 'camera:=true', 'mode:=lockstep')
    with (
        private_domain() as domain,
        start_program('simulation', domain, *words) as program,
        start_program('camera', domain) as camera,
    ):
        program.wait_for_line("simulation of 'sunday' runs", PATIENCE)
        camera.wait_for_line('cameras: camera; drawn by', PATIENCE)
        with ClientNode(domain, 'camera_user') as client:
            yield WorldUser(client, program, Path())


@statement('E6')
def test_steps_wait_for_their_pictures_and_repeat_them(lockstep: WorldUser) -> None:
    """A step is answered after the pictures that were due; the same fall the same bytes."""
    pictures = lockstep.client.collect('/camera/color/image_raw', Image)

    def step(count: int) -> None:
        code, text = lockstep.result('step_simulation', steps=count)
        assert code == OK, text

    for _ in range(1000):  # until the publisher has found the subscription
        step(100)
        if pictures.messages:
            break
    runs = []
    for _ in range(2):
        assert lockstep.result('reset_simulation', scope=STATE)[0] == OK
        assert lockstep.spawn('ball', (0.4, -0.12, 1.7), BALL).result.result == OK
        pictures.clear()
        begin_ns = lockstep.time_ns()
        step(300)
        stamps = [begin_ns + PERIOD_NS * number for number in (1, 2, 3)]
        pictures.wait(len(stamps), PATIENCE)
        assert [ns_from_time(one.header.stamp) for one in pictures.messages] == stamps
        runs.append([bytes(one.data) for one in pictures.messages])
        assert lockstep.result('delete_entity', entity='ball')[0] == OK
    assert runs[0] == runs[1]
    assert runs[0][0] != runs[0][1]
