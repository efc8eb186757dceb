# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The topic of ``ur_controllers/FreedriveModeController``."""

import asyncio
from types import SimpleNamespace

import pytest
from std_msgs.msg import Bool

from armsim_ros.config.base import FreedriveModeControllerParameters
from armsim_ros.nodes.vendors.ur_endpoints import Freedrive


class Arm:
    """An arm that is in freedrive or not, and what was warned of."""

    def __init__(self, freedrive, obstacle):
        self.freedrive, self.obstacle = freedrive, obstacle
        self.warnings, self.receive = [], None

    def set_freedrive(self, on):
        """Be in freedrive or not."""
        self.freedrive = on

    async def change(self, do):
        """Do it at once."""
        do()

    def topic(self, active=True, **parameters):
        """Return the topic of a controller; ``receive`` gets its messages."""
        return Freedrive(
            SimpleNamespace(arm=self, time_ns=5, change=self.change,
                            loop=SimpleNamespace(call=lambda do: do())),
            SimpleNamespace(active=active, events=SimpleNamespace(
                warn=lambda time_ns, text: self.warnings.append(text)),
                parameters=FreedriveModeControllerParameters(**parameters)),
            SimpleNamespace(create_subscription=lambda kind, name, receive, depth: setattr(
                self, 'receive', receive)))

    def hear(self, value, active=True, **parameters):
        """Receive a message; return the topic."""
        topic = self.topic(active, **parameters)
        asyncio.run(self.receive(Bool(data=value)))
        return topic


@pytest.mark.parametrize(('before', 'obstacle', 'value', 'after'), [
    (False, '', True, True), (True, '', False, False),
    (False, 'a protective stop', True, False), (True, 'a protective stop', False, False)])
def test_freedrive_begins_unless_something_is_in_its_way_and_always_ends(
    before, obstacle, value, after
):
    """What is in its way is a warning."""
    arm = Arm(before, obstacle)
    arm.hear(value)
    assert arm.freedrive is after
    assert arm.warnings == ([f'no freedrive: {obstacle}'] if value and obstacle else [])


def test_an_inactive_controller_changes_nothing():
    """Without a warning."""
    arm = Arm(False, '')
    arm.hear(True, active=False)
    assert (arm.freedrive, arm.warnings) == (False, [])


@pytest.mark.parametrize(('parameters', 'timeout_ns'), [
    ({}, 1_000_000_000), ({'inactive_timeout': 3}, 3_000_000_000)])
def test_freedrive_ends_when_nothing_asks_for_it(parameters, timeout_ns):
    """After ``inactive_timeout`` (start_timer, timeout_callback of freedrive_mode_controller)."""
    arm = Arm(False, '')
    topic = arm.hear(True, **parameters)
    topic.publish(5 + timeout_ns - 1)
    assert arm.freedrive
    topic.publish(5 + timeout_ns)
    assert not arm.freedrive


@pytest.mark.parametrize('active', [True, False])
def test_a_controller_ends_no_freedrive_of_another(active):
    """Re-enacts freedrive_mode_controller.cpp, timeout_callback: only while freedrive_active_."""
    arm = Arm(False, '')
    other = arm.topic(active)
    arm.hear(True)
    other.publish(2_000_000_000)
    assert arm.freedrive


def test_a_controller_forgets_a_freedrive_that_a_stop_has_ended():
    """What another begins later is not its own."""
    arm = Arm(False, '')
    topic = arm.hear(True)
    arm.set_freedrive(False)
    topic.publish(6)
    arm.hear(True)
    topic.publish(2_000_000_000)
    assert arm.freedrive
