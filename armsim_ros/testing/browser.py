# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The machine's own Chromium, headless, for tests and pictures of pages."""

from __future__ import annotations

import shutil
from typing import Any

#: No graphics card is needed, and nothing but the page is loaded.
FLAGS = (
    '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync',
    '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
)


def chromium_path() -> str | None:
    """Return where Chromium lies, None where it is not installed."""
    return shutil.which('chromium') or shutil.which('chromium-browser')


def launch_chromium(playwright: Any) -> Any:
    """
    Start a browser with a profile of its own.

    :param playwright: what playwright's ``sync_playwright()`` gives.
    """
    return playwright.chromium.launch(executable_path=chromium_path(), args=list(FLAGS))
