# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What the simulation sends to the program that draws, and when."""

from multiprocessing.connection import Client
import threading

import pytest

from armsim_ros.cli.arguments import parse_arguments
from armsim_ros.cli.settings import cell_of
from armsim_ros.model.geometry import Box
from armsim_ros.model.transforms import pose_matrix
from armsim_ros.model.world_objects import WorldObject
from armsim_ros.nodes.camera.link import FAMILY, PLANT, read_greeting, SNAPSHOT
from armsim_ros.nodes.simulation.camera_feed import CameraFeed
from armsim_ros.sim.assembly import build_control, build_simulation
from armsim_ros.sim.camera import cameras_of, Snapshot
from armsim_ros.sim.control_loop import ControlLoop

#: An answer takes no longer on a busy machine [s].
PATIENCE = 60.0
PERIOD_NS = 100_000_000
BOX = WorldObject.of_shape('box', Box((0.1, 0.1, 0.1)), pose_matrix((0.5, 0.5, 0.5)))


@pytest.fixture(scope='module')
def cell():
    """Return the robot with a camera."""
    return cell_of(parse_arguments(['robot:=sunday', 'world:=empty']))[0]


@pytest.fixture
def make_feed(cell, tmp_path):
    """Return a function that makes a loop with a feed, and a client of it."""
    feeds, clients, complaints = [], [], []

    def make(*, lockstep):
        simulation = build_simulation(cell.settings, cell.model)
        loop = ControlLoop(simulation, build_control(cell, simulation).controllers, 1000)
        cameras = cameras_of(cell.settings.simulation.cameras, cell.model)
        path = tmp_path / 'camera.socket'
        feed = CameraFeed(loop, cameras, path, complaints.append, lockstep=lockstep)
        client = Client(str(path), FAMILY)
        feeds.append(feed)
        clients.append(client)
        assert read_greeting(client.recv_bytes()) == (cameras, lockstep)
        assert received(client)[0] == PLANT
        return loop, client

    yield make
    for one in (*clients, *feeds):
        one.close()
    assert complaints == []


def received(client):
    """Return the next message."""
    assert client.poll(PATIENCE)
    message = client.recv_bytes()
    return message[:1], message[1:]


def advance_until_sent(loop, client):
    """Move time until something was sent; the request arrives in a thread of the feed."""
    for _ in range(1000):
        loop.advance(PERIOD_NS // loop.clock.step_ns)
        if client.poll(0.05):
            return
    pytest.fail('nothing was sent')


def test_a_snapshot_comes_for_each_request(make_feed):
    """It is of a multiple of the period; without a request nothing comes."""
    loop, client = make_feed(lockstep=False)
    loop.advance(300)
    assert not client.poll(0.0)
    client.send_bytes(bytes([0]))
    advance_until_sent(loop, client)
    kind, content = received(client)
    snapshot = Snapshot.from_bytes(content)
    assert (kind, snapshot.camera, snapshot.time_ns % PERIOD_NS) == (SNAPSHOT, 0, 0)
    loop.advance(300)
    assert not client.poll(0.2)


def test_a_changed_world_is_sent_before_its_first_snapshot(make_feed):
    """The plant comes again, and only then."""
    loop, client = make_feed(lockstep=False)
    kinds = []
    for added in (False, False, True):
        if added:
            loop.simulation.world.add(BOX)
        client.send_bytes(bytes([0]))
        advance_until_sent(loop, client)
        kinds.append('')
        while not kinds[-1].endswith(SNAPSHOT.decode()):
            kinds[-1] += received(client)[0].decode()
    assert kinds == ['S', 'S', 'PS']


def test_lockstep_waits_until_the_picture_is_out(make_feed):
    """A due picture holds time back until it is answered for."""
    loop, client = make_feed(lockstep=True)
    arrived = threading.Event()

    def step():
        loop.advance(2 * PERIOD_NS // loop.clock.step_ns)
        arrived.set()

    threading.Thread(target=step, daemon=True).start()
    times = []
    while not arrived.is_set():
        if not client.poll(0.01):
            continue
        kind, content = received(client)
        assert kind == SNAPSHOT
        assert not arrived.is_set()
        times.append(Snapshot.from_bytes(content).time_ns)
        assert loop.clock.now_ns == times[-1]
        client.send_bytes(bytes([0]))
    assert times[-2:] == [PERIOD_NS, 2 * PERIOD_NS]


def test_lockstep_goes_on_without_a_program_that_draws(make_feed):
    """When it goes, nobody waits for it."""
    loop, client = make_feed(lockstep=True)
    client.close()
    loop.advance(3 * PERIOD_NS // loop.clock.step_ns)
    assert loop.clock.now_ns == 3 * PERIOD_NS
