# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What a person sees while something takes its time, and how he ends it."""

import re

import pytest

pytest.importorskip('viser')
pytest.importorskip('playwright')

from armsim_ros.testing.page_user import chromium_path

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(chromium_path() is None, reason='needs Debian package chromium'),
]


@pytest.fixture(scope='module')
def opened(served_page, open_window):
    """Open the page once for this file."""
    return open_window(served_page.server.address)


@pytest.fixture
def page(fake_stack, opened):
    """Return the page before a motion from zero; nothing failed in the browser."""
    fake_stack.positions.update(turn=0.0, bend=0.0)
    opened.choose('Goal state', 'up')
    opened.wait_for_verdict('reachable')
    assert not opened.tab.locator('#progress').is_visible()
    yield opened
    fake_stack.planned.set()
    fake_stack.release.set()
    opened.wait_until_ready()
    assert not opened.tab.locator('#progress').is_visible()
    assert opened.page_errors == []


def test_a_motion_shows_how_far_it_is(fake_stack, page):
    """Seconds in the status line, and a bar that grows until the motion has ended."""
    fake_stack.release.clear()
    page.press('Plan & Execute')
    page.wait_for_status('Executing')
    page.tab.wait_for_function('document.getElementById("progress").value > 0.2')
    assert page.tab.locator('#progress').is_visible()
    elapsed, total = re.findall('[0-9.]+', page.tab.inner_text('#status-text'))
    assert (0.0 < float(elapsed) <= float(total), float(total)) == (True, 2.0)
    fake_stack.release.set()
    page.wait_for_result('arrived')


def test_a_long_plan_shows_how_long_it_takes_and_is_stopped(fake_stack, page):
    """It says how long it may take; after 'Stop' nothing moves."""
    fake_stack.planned.clear()
    page.unfold('Options')
    page.field('Planning time').fill('100')
    page.press('Plan & Execute')
    page.wait_for_status('of 100.0 s at most')
    assert page.tab.locator('#progress').is_visible()
    page.press('Stop')
    page.wait_for_result('stopped')
    assert fake_stack.positions == {'turn': 0.0, 'bend': 0.0}
