# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Which HTTP requests a server answers: Host, Origin and token are checked before all else."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
import hmac
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from armsim_ros.nodes.serving.ports import is_loopback


@dataclass(frozen=True)
class AccessRules:
    """
    The rules of a server at an address.

    A loopback address answers only requests for a loopback name, so that no other site can point
    its own name at this machine (DNS rebinding). Elsewhere the token protects against that.

    :param host: the address that the server is bound to.
    :param token: what each request must bring; '' admits requests without a token.
    :param cookie: name of a cookie that may bring the token, '' for none.
    :param origins: pages of other sites that may connect, such as ``https://a.example``; their
        names are also accepted as Host.
    :param local_pages: whether pages of any port of this machine may connect.
    :param host_refusal: the answer to a request for a foreign name.
    :param origin_refusal: the answer to a foreign page, which it names as ``{origin}``.
    :param token_refusal: the answer to a request without the token.
    """

    host: str
    token: str
    host_refusal: str
    origin_refusal: str
    token_refusal: str
    cookie: str = ''
    origins: Collection[str] = ()
    local_pages: bool = False

    def refusal(self, request: Request) -> Response | None:
        """Return why a request is not answered, None where it is."""
        host = request.headers.get('Host', '')
        if is_loopback(self.host) and not self._is_own_name(_name_of(f'//{host}')):
            return answer(HTTPStatus.FORBIDDEN, self.host_refusal)
        origin = request.headers.get('Origin')
        if origin is not None and not self._admits_page(origin, host):
            shown = ''.join(filter(str.isprintable, origin))[:200]
            return answer(HTTPStatus.FORBIDDEN, self.origin_refusal.format(origin=shown))
        if self.token and not any(
                hmac.compare_digest(given.encode('utf-8', 'replace'), self.token.encode())
                for given in self._given_tokens(request)):
            return answer(HTTPStatus.UNAUTHORIZED, self.token_refusal)
        return None

    def _is_own_name(self, name: str) -> bool:
        return is_loopback(name) or name == self.host or (name != '' and any(
            name == _name_of(origin) for origin in self.origins))

    def _admits_page(self, origin: str, host: str) -> bool:
        if origin in self.origins:
            return True
        try:
            parts = urlsplit(origin)
        except ValueError:
            return False
        if parts.netloc and parts.netloc == host:
            return True
        return self.local_pages and parts.scheme in ('http', 'https') and is_loopback(
            _name_of(origin))

    def _given_tokens(self, request: Request) -> list[str]:
        try:
            given = parse_qs(urlsplit(request.path).query).get('token', [])
        except ValueError:
            given = []
        for header in request.headers.get_all('Authorization'):
            kind, _, value = header.partition(' ')
            if kind.lower() == 'bearer':
                given.append(value.strip())
        if self.cookie:
            pairs = [pair.strip().partition('=') for header in request.headers.get_all('Cookie')
                     for pair in header.split(';')]
            given += [value for key, _, value in pairs if key == self.cookie]
        return given


def answer(status: HTTPStatus, body: str | bytes, kind: str = 'text/plain; charset=utf-8'
           ) -> Response:
    """Return a complete HTTP response that ends the connection."""
    data = body.encode() if isinstance(body, str) else body
    return Response(status.value, status.phrase, Headers({
        'Content-Type': kind,
        'Content-Length': str(len(data)),
        'Cache-Control': 'no-cache',
        'Referrer-Policy': 'no-referrer',
        'X-Content-Type-Options': 'nosniff',
        'X-Frame-Options': 'SAMEORIGIN',
        'Connection': 'close',
    }), data)


def _name_of(url: str) -> str:
    """Return the host of an address without its port, '' where there is none."""
    try:
        return urlsplit(url).hostname or ''
    except ValueError:
        return ''
