# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""When ros2 topic echo ends."""

import pytest

from armsim_ros2.commands import topic_echo
from armsim_ros2.parsing import Parser


class Session:
    """A session in which a message comes after a while; its clock is the test's."""

    def __init__(self, arrival):
        self.node = self
        self.now, self._arrival, self._receive = 100.0, arrival, None

    def monotonic(self):
        """Return the time [s]."""
        return self.now

    def absolute(self, name):
        """Return a full name."""
        return name

    def settle(self):
        """Know the graph already."""

    def get_publishers_info_by_topic(self, _):
        """Return no publisher."""
        return []

    def count_publishers(self, _):
        """Return one publisher."""
        return 1

    def names(self, _):
        """Return no name."""
        return {}

    def create_subscription(self, _kind, _topic, receive, *_, **__):
        """Keep what takes the message."""
        self._receive = receive

    def spin(self, done, limit):
        """Let time pass until it is done or over."""
        end = self.now + limit
        if not done() and self.now < self._arrival <= end:
            self.now = self._arrival
            self._receive(b'', {})
        self.now = self.now if done() else end
        return done()


@pytest.mark.parametrize('arrival', [102.5, 104.0, 200.0])
def test_a_timeout_counts_from_the_start(monkeypatch, capsys, arrival):
    """A message does not begin it anew (ros2topic/verb/echo.py, main: one timer)."""
    session = Session(arrival)
    monkeypatch.setattr(topic_echo, 'time', session)
    parser = Parser()
    for add in topic_echo.ECHO.arguments:
        add(parser)
    options = parser.parse_args(['/x', 'std_msgs/msg/String', '--raw', '--timeout', '5'])
    topic_echo._echo(session, options)
    assert session.now == 105.0
