# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A page beside a stack that is not ours; a real browser, and windows of it."""

import pytest

#: For what a page shows after a while [ms].
PATIENCE = 120_000


@pytest.fixture(scope='module')
def served_page(fake_stack):
    """Serve a page in this process."""
    from armsim_ros.clients.ros_client import RosClient
    from armsim_ros.nodes.web.main import WebArguments
    from armsim_ros.nodes.web.page import Page
    from armsim_ros.nodes.web.program import page_parts

    with RosClient('web') as link:
        opened = Page(link)
        opened.open('127.0.0.1', 8450, '', lambda page: page_parts(page, WebArguments()))
        yield opened
        opened.close()


@pytest.fixture(scope='module')
def browser():
    """Start the machine's Chromium, and end it with the file: it has an event loop running."""
    from playwright.sync_api import sync_playwright

    from armsim_ros.testing.page_user import launch_chromium

    with sync_playwright() as programs:
        chromium = launch_chromium(programs)
        yield chromium
        chromium.close()


@pytest.fixture(scope='module')
def open_window(browser):
    """Return a function that opens the page at an address in a window of its own."""
    from armsim_ros.testing.page_user import PageUser

    def open_window(address):
        window = browser.new_context(viewport={'width': 800, 'height': 520})
        window.set_default_timeout(PATIENCE)
        user = PageUser(window.new_page(), address)
        user.open()
        return user

    return open_window
