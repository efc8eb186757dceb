# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""From bringup's address to the moved arm in three clicks, with different robots."""

from contextlib import contextmanager
import re

import numpy as np
import pytest

pytest.importorskip('viser')
pytest.importorskip('playwright')

from public_robots import public_urdf

from armsim_ros.testing.page_user import changed, chromium_path, printed_address, robot_is_seen
from armsim_ros.testing.robot_user import running_robot
from armsim_ros.tools.generate_config.main import generate_config

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(chromium_path() is None, reason='needs Debian package chromium'),
]


@pytest.fixture
def bring_up(open_window):
    """Return a context: a robot that bringup started with its page, and the page, just loaded."""
    @contextmanager
    def context(robot, namespace='', *arguments):
        with running_robot('web:=true', f'robot:={robot}', *arguments,
                           namespace=namespace) as user:
            page = open_window(printed_address(user.program.wait_for_line('page: http', 60)))
            page.wait_for_picture(robot_is_seen)
            yield user, page
            page.tab.context.close()
            assert page.page_errors == []

    return context


def test_three_clicks_move_sunday(bring_up):
    """The robot that comes along, as 'make bringup' starts it."""
    with bring_up('sunday', '/sunday') as (user, page):
        page.go('scan_food')
        assert user.distance(user.move_group.named_states()['manipulator', 'scan_food']) < 0.01


def test_jog_buttons_move_the_tool_or_name_a_way_out(bring_up):
    """From `ready` each moves it 20 mm while a key holds it; in `home` the page has the reason."""
    with bring_up('sunday', '/sunday', 'servo:=true') as (user, page):
        keyboard = page.tab.keyboard

        def hold(label, done):
            page.tab.get_by_label(label, exact=True).focus()
            keyboard.down('Enter')
            result = done()
            keyboard.up('Enter')
            return result

        def tool():
            return user.move_group.pose('link_6', user.positions(), 'world')[:3, 3]

        def moved():
            return any(np.linalg.norm(tool() - start) > 0.02 for _ in range(100))

        page.go('ready')
        page.unfold('Jog')
        for axis in 'xyz':
            for way in ('forwards', 'backwards'):
                start = tool()
                assert hold(f'tool {axis} {way}', moved), (axis, way)
        page.go('home')
        status = page.tab.locator('#jog-status')
        reason = status.filter(has_text=re.compile('singularity.*free: ', re.DOTALL))
        hold('tool z backwards', reason.wait_for)


def test_three_clicks_move_a_panda_with_meshes(bring_up, tmp_path):
    """All its visual meshes are found and drawn, from where its URDF was published."""
    generate_config(public_urdf('panda'), tmp_path / 'panda', states=1000)
    with bring_up(tmp_path / 'panda') as (user, page):
        assert not page.tab.locator('#note').is_visible()
        rest = page.resting_picture()
        page.go('ready')
        assert user.distance(user.move_group.named_states()['arm', 'ready']) < 0.01
        page.wait_for_picture(lambda now: changed(rest, now) > 300)


def test_three_clicks_move_one_of_two_arms_and_a_fourth_moves_both(bring_up):
    """The first arm is what is planned for; with the group of both, the other comes too."""
    with bring_up('two_bots', '/left') as (user, page):
        states = user.move_group.named_states()
        page.go('ready')
        assert user.distance(states['left_arm', 'ready']) < 0.01
        rest = page.resting_picture()
        page.choose('Group', 'both_arms')
        page.tab.wait_for_function('document.getElementById("goal-state").value === "current"')
        page.go('ready')
        page.wait_for_picture(lambda now: changed(rest, now) > 300)
