# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Why an environment cannot be made, in a sentence the user can act on."""

from __future__ import annotations

from pathlib import Path
import re

_UNREACHABLE = re.compile(
    r'Retrying \(Retry|NewConnectionError|Temporary failure in name resolution|'
    r'Failed to establish a new connection|ProxyError|ConnectTimeoutError|Network is unreachable',
    re.IGNORECASE)
_FULL = re.compile(r'No space left on device')
_NO_RELEASE = re.compile(r'No matching distribution found for (\S.*)')
_SHOWN_LINES = 6


class SetupError(Exception):
    """Something that the environment needs is missing; the text names it and the remedy."""


def pip_failure(task: str, output: str, log: Path) -> SetupError:
    """
    Explain a failed pip.

    :param task: what pip was to do, as the end of "cannot ...".
    :param output: everything that it printed.
    :param log: the file that holds the output.
    """
    see = f'; all of it: {log}'
    if _FULL.search(output):
        return SetupError(f'cannot {task}: the disk is full{see}')
    if _UNREACHABLE.search(output):
        return SetupError(
            f'cannot {task}: the Python package index does not answer; check the network, or '
            f'name a proxy (HTTPS_PROXY) or a mirror (PIP_INDEX_URL){see}')
    missing = _NO_RELEASE.search(output)
    if missing:
        return SetupError(
            f'cannot {task}: there is no {missing.group(1)} for this Python and platform{see}')
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    telling = [line for line in lines if re.match(r'(ERROR|error|fatal)\b', line)] or lines
    return SetupError('\n  '.join([f'cannot {task}{see}', *telling[-_SHOWN_LINES:]]))
