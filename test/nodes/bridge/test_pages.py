# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Pages in a real browser: those of this machine may connect, and no others."""

from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
import threading

import pytest

pytest.importorskip('playwright')
pytest.importorskip('foxglove')

from armsim_ros.testing.page_user import chromium_path, launch_chromium

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(chromium_path() is None, reason='needs Debian package chromium'),
]

FOREIGN = 'evil.example'
#: Opens a websocket, and asks for something if it may.
CONNECT = """([url, protocols]) => new Promise((done) => {
  const socket = new WebSocket(url, protocols);
  socket.onopen = () => {
    socket.send('{"op": "call_service", "service": "/rosapi/get_time"}');
  };
  socket.onmessage = () => done('answered');
  socket.onerror = () => done('refused');
})"""


@pytest.fixture(scope='module')
def arguments():
    """Ask for a token, and let clients of Foxglove do all."""
    return ['token:=word', 'foxglove:=control', 'foxglove_port:=0']


@pytest.fixture
def page_port(tmp_path):
    """Serve an empty page at a port of its own."""
    (tmp_path / 'index.html').write_text('<!doctype html><title>page</title>')
    handler = partial(SimpleHTTPRequestHandler, directory=tmp_path)
    with ThreadingHTTPServer(('127.0.0.1', 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_port
        server.shutdown()


@pytest.fixture
def tab():
    """Open a tab, in a browser for which a foreign name is this machine's address."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as programs:
        browser = launch_chromium(
            programs, f'--host-resolver-rules=MAP {FOREIGN} 127.0.0.1')
        yield browser.new_page()
        browser.close()


def test_pages_of_other_sites_are_refused(bridge, page_port, tab):
    """A foreign origin, a name that is pointed at this machine, a token that is missing."""
    found = {}
    ports = {'rosbridge': [], 'foxglove': ['foxglove.sdk.v1']}
    urls = {name: bridge.wait_for_line(f'{name}: ws', 30).partition(': ')[2] for name in ports}
    for name, protocols in ports.items():
        url = urls[name]
        bare, _, query = url.partition('/?')
        moved = url.replace('127.0.0.1', FOREIGN)
        for case, page, target in (
                ('local', f'http://localhost:{page_port}/', url),
                ('no token', f'http://localhost:{page_port}/', bare),
                ('foreign', f'http://{FOREIGN}:{page_port}/', url),
                ('rebound', f'http{bare[2:]}/?{query}'.replace('127.0.0.1', FOREIGN), moved)):
            tab.goto(page)
            found[name, case] = tab.evaluate(CONNECT, [target, protocols])
    assert {case for case, outcome in found.items() if outcome == 'answered'} == {
        ('rosbridge', 'local'), ('foxglove', 'local')}
    assert len(found) == 8
