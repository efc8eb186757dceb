# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""How the page repeats a jog to servo, and what it shows of servo's status."""

import asyncio
from types import SimpleNamespace

from moveit_msgs.msg import ServoStatus
from moveit_msgs.srv import ServoCommandType
import pytest

pytest.importorskip('viser')

from armsim_ros.nodes.web.parts import jog
from armsim_ros.nodes.web.parts.jog import Jog, JogPart

WARNING = 'Very close to a singularity, emergency stop; free: -x of base_link'


class Bench(SimpleNamespace):
    """A page, its link and a servo whose status a test writes; all in the test's thread."""

    def __init__(self, *statuses):
        super().__init__(
            sent=[], shown=[], closed=False, link=self, robot=None, now=lambda: 1.0,
            goal=lambda session: SimpleNamespace(group=''), start=asyncio.ensure_future,
            statuses=[ServoStatus(message=text) for text in statuses])

    async def call(self, kind, name, request):
        return ServoCommandType.Response(success=True)

    def poll(self, kind, name, profile):
        return self

    def take(self):
        return [self.statuses.pop(0)] if self.statuses else []

    def close(self):
        self.closed = True

    def publish(self, name, value=None):
        """Take a section of the page, or a message to servo."""
        if value is None:
            self.sent.append(name)
        else:
            self.shown.append((name, value))

    def in_thread(self, work):
        work()


def part_on(bench):
    """Return the part, with a servo found."""
    part = JogPart(bench, bench, bench)
    part._servo, part._publishers = '/servo_node', {
        'delta_twist_cmds': bench, 'delta_joint_cmds': bench}
    return part


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    """Repeat at once."""
    monkeypatch.setattr(jog, '_COMMAND_PERIOD', 0.0)


def test_a_command_is_repeated_until_the_button_is_released():
    """However slow the browser is; the last command to servo is a stop."""
    async def work():
        bench = Bench()
        part = part_on(bench)
        await part._jog(None, Jog(joint='joint_1', share=0.5))
        while len(bench.sent) < 3:
            await asyncio.sleep(0)
        await part._jog(None, Jog(joint='joint_1', share=0.0))
        await part._stream
        return bench

    bench = asyncio.run(work())
    assert [each.velocities[0] for each in bench.sent[:3]] == [0.5] * 3
    assert bench.sent[-1].velocities[0] == 0.0
    assert bench.closed


def test_a_silent_panel_ends_the_motion(monkeypatch):
    """A tab that is gone sends no stop."""
    monkeypatch.setattr(jog, '_HOLD', 0.01)

    async def work():
        bench = Bench()
        part = part_on(bench)
        await part._jog(None, Jog(axis='x', share=0.5))
        await part._stream
        return bench

    assert asyncio.run(work()).closed


def test_the_reason_for_a_jog_that_stops_is_shown_and_cleared():
    """Servo's warning, until servo has none any more."""
    async def work():
        bench = Bench(WARNING, 'No warnings')
        part = part_on(bench)
        await part._jog(None, Jog(axis='z', share=-0.5))
        while bench.statuses:
            await asyncio.sleep(0)
        await part._jog(None, Jog(axis='z', share=0.0))
        await part._stream
        return bench

    assert asyncio.run(work()).shown == [('servo_status', WARNING), ('servo_status', '')]
