# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``armsim teleop --record``: a person's episodes of a task, in a data set."""

from contextlib import closing
import json
import time

import numpy as np
import pyarrow.parquet as pq
import pytest
from sensor_msgs.msg import JointState
from teleop_terminal import Teleop

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain


def shows(teleop, text, count=1, timeout=60.0):
    """Wait until a text is printed so many times."""
    deadline = time.monotonic() + timeout
    while teleop.text.count(text) < count:
        assert time.monotonic() < deadline, teleop.text
        time.sleep(0.02)


def test_episodes_of_keys_are_kept_or_dropped(tmp_path):
    """Space starts and ends an episode, backspace drops it; Ctrl-C leaves a whole set."""
    folder = tmp_path / 'set'
    with private_domain() as domain, closing(Teleop(
            domain, '--with', 'keyboard', '--speed', '1', '--record', 'armsim/Reach-v1',
            str(folder))) as teleop:
        shows(teleop, 'space starts the episode')
        teleop.press(' ')
        shows(teleop, 'recording; ')
        for _ in range(20):
            teleop.press('1')
        teleop.press(' ')
        shows(teleop, 'episode 0: ')
        teleop.press(' ')
        shows(teleop, 'recording; ', 2)
        teleop.press('\x7f')
        shows(teleop, 'the episode is dropped')
        assert teleop.end() == 0
        assert "1 episodes are in '" in teleop.text
        assert 'Traceback' not in teleop.text
    info = json.loads((folder / 'meta/info.json').read_text())
    assert (info['total_episodes'], info['fps']) == (1, 20)
    rows = pq.read_table(folder / 'data/chunk-000/file-000.parquet').to_pydict()
    states = np.array(rows['observation.state'])
    assert states[-1, 0] - states[0, 0] > 0.1
    assert np.abs(states[-1, 1:6] - states[0, 1:6]).max() < 0.02
    assert np.ravel(rows['next.done']).tolist() == [False] * (len(states) - 1) + [True]
    own = json.loads((folder / 'meta/armsim.json').read_text())
    assert own['policy'] == 'teleop keyboard'


def test_a_leaders_positions_are_the_actions(tmp_path):
    """From the start of the episode on, at the speed that is allowed."""
    folder = tmp_path / 'set'
    with private_domain() as domain, ClientNode(domain, 'leader_driver') as driver:
        states = driver.collect('/sunday/joint_states', JointState)
        publisher = driver.node.create_publisher(JointState, '/leader', 10)
        message = JointState(name=[f'joint_{k}' for k in range(1, 7)], position=[0.0] * 6)
        driver.node.create_timer(0.02, lambda: publisher.publish(message))
        with closing(Teleop(domain, '--with', 'leader:/leader', '--record', 'armsim/Reach-v1',
                            str(folder))) as teleop:
            shows(teleop, 'space starts the episode')
            last = states.wait()[-1]
            at = dict(zip(last.name, last.position, strict=True))
            message.position = [at[name] + 0.05 for name in message.name]
            teleop.press(' ')
            shows(teleop, 'recording; ')
            for _ in range(20):
                teleop.press('')
            teleop.press(' ')
            shows(teleop, 'episode 0: ')
            assert teleop.end() == 0
    rows = pq.read_table(folder / 'data/chunk-000/file-000.parquet').to_pydict()
    reached = np.array(rows['observation.state'])[-1, :6]
    assert reached == pytest.approx(list(message.position), abs=5e-3)
