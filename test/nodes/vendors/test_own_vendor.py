# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The vendor of a user's own that docs/hardware.md shows."""

from contextlib import contextmanager
from pathlib import Path
import shutil

from documents import blocks, ROOT
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

from armsim_ros.clients.client_node import ClientNode
from armsim_ros.testing.program import private_domain, Program, ros_environment

ROBOT = Path(__file__).parents[2] / 'support/robots/hand'


@contextmanager
def simulation(folder, vendor):
    """Start a simulation with a vendor, whose module may be in a folder; give a client."""
    robot = folder / 'hand'
    shutil.copytree(ROBOT, robot)
    with (robot / 'simulation.yaml').open('a') as file:
        file.write(f'\nhardware: {{vendor: {vendor}}}\n')
    with private_domain() as domain:
        environment = ros_environment(domain) | {'PYTHONPATH': f'{folder}:{ROOT}'}
        program = Program.module(
            'armsim_ros', 'simulation', f'robot:={robot}', environment=environment)
        try:
            with ClientNode(domain, 'client') as client:
                yield client
        finally:
            program.stop()


def press(client, button, pressed=True):
    """Press or release a button."""
    request = SetBool.Request(data=pressed)
    assert client.call(f'/hand/{button}', SetBool, request, timeout=60.0).success


def test_the_example_of_the_page_gives_an_arm_its_endpoints(tmp_path):
    """Its service answers as it says, and its delay holds for a stop."""
    (block,) = (block for block in blocks(ROOT / 'docs/hardware.md')
                if block.language == 'python' and 'class MyEndpoints' in block.text)
    assert len(block.text.splitlines()) <= 36
    text = block.text.replace('unlock_delay=2.0', 'unlock_delay=600.0')
    (tmp_path / 'my_vendor.py').write_text(text)
    with simulation(tmp_path, 'my_vendor') as client:
        assert client.call('/hand/my_driver/open_valve', Trigger, timeout=60.0).success
        client.collect('/hand/my_driver/valve', Bool).wait_for(lambda message: message.data)
        press(client, 'protective_stop')
        refused = client.call('/hand/my_driver/open_valve', Trigger)
        assert (refused.success, refused.message) == (False, 'protective stop: injected')
        assert '600 s after' in client.call('/hand/clear_stop', Trigger).message
