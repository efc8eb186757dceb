# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which requests a server answers."""

import pytest

pytest.importorskip('websockets')

from websockets.datastructures import Headers
from websockets.http11 import Request

from armsim_ros.nodes.access import AccessRules, RateLimit


def status(path='/', *, host='127.0.0.1', token='', cookie='', origins=(), local_pages=True,
           **headers):
    """Return the status of a refusal, 0 where there is none."""
    rules = AccessRules(host, token, 'host', 'origin {origin}', 'token', cookie=cookie,
                        origins=origins, local_pages=local_pages)
    given = Headers({'Host': '127.0.0.1:9090', **headers})
    refusal = rules.refusal(Request(path, given))
    return 0 if refusal is None else refusal.status_code


@pytest.mark.parametrize(('name', 'expected'), [
    ('localhost:9090', 0), ('127.0.0.1', 0), ('[::1]:9090', 0), ('evil.example', 403),
    ('evil.example:9090', 403), ('', 403), ('[', 403), ('127.0.0.1.evil.example', 403)])
def test_a_loopback_server_answers_to_loopback_names(name, expected):
    """A name that another site points at this machine is refused."""
    assert status(Host=name) == expected
    assert status(Host='a.example', origins=['https://a.example']) == 0
    assert status(Host='', origins=['null', 'file://']) == 403


@pytest.mark.parametrize(('origin', 'expected'), [
    ('http://127.0.0.1:9090', 0), ('http://localhost:5173', 0), ('https://[::1]', 0),
    ('https://evil.example', 403), ('null', 403), ('file://', 403), ('http://[', 403),
    ('http://localhost.evil.example', 403), ('ftp://localhost', 403)])
def test_pages_of_other_sites_are_refused(origin, expected):
    """Those of this machine may connect, and those that are listed."""
    assert status(Origin=origin) == expected
    assert status(Origin=origin, origins=[origin]) == 0


def test_pages_of_other_ports_may_be_refused():
    """The page's own server talks to its own page only."""
    assert status(Origin='http://localhost:5173', local_pages=False) == 403
    assert status(Origin='http://127.0.0.1:9090', local_pages=False) == 0


def test_a_token_comes_in_one_of_three_ways():
    """In the address, as a bearer, in the cookie of the page."""
    assert status(token='secret') == 401
    assert status('/?token=wrong', token='secret') == 401
    assert status('/?token=secret', token='secret') == 0
    assert status(token='secret', Authorization='Bearer secret') == 0
    assert status(token='secret', Authorization='Basic secret') == 401
    assert status(token='secret', Cookie='a=b; page=secret', cookie='page') == 0
    assert status(token='secret', Cookie='a=b; page=secret') == 401
    assert status('/?token=\ud800', token='secret') == 401


def test_a_rate_limit_delays_what_comes_quicker():
    """After the burst, a message each tenth of a second."""
    limit = RateLimit(2.0, 10.0)
    assert [limit.delay(100.0) for _ in range(4)] == pytest.approx([0.0, 0.0, 0.1, 0.2])
    assert limit.delay(101.0) == 0.0
