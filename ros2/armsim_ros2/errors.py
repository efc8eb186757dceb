# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Errors of a command, and hints about names."""

from __future__ import annotations

from collections.abc import Iterable
import difflib


class CliError(Exception):
    """
    The command failed; the text is one line for the user.

    :param text: may be empty.
    :param status: of the process.
    """

    def __init__(self, text: str, status: int = 1) -> None:
        super().__init__(text)
        self.status = status


def hint(name: str, known: Iterable[str]) -> str:
    """Return ``; did you mean 'x'?`` with the most similar known name, or an empty text."""
    found = difflib.get_close_matches(name, list(known), n=1)
    return f"; did you mean '{found[0]}'?" if found else ''
