# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A person before the page: sees its picture, presses what has a name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
import io
import re
import shutil
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Picture = NDArray[np.int16]

#: A part of a picture has changed where a colour differs by more than this (0..255).
_CLEARLY = 40
#: Period of reading the picture [ms]; the browser's own clock.
_LOOK = 60

#: No graphics card is needed, and nothing but the page is loaded.
_FLAGS = (
    '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync',
    '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader')


def chromium_path() -> str | None:
    """Return where Chromium lies, None where it is not installed."""
    return shutil.which('chromium') or shutil.which('chromium-browser')


def launch_chromium(playwright: Any, *flags: str) -> Any:
    """
    Start a browser with a profile of its own.

    :param playwright: what playwright's ``sync_playwright()`` gives.
    :param flags: more of its command line.
    """
    return playwright.chromium.launch(executable_path=chromium_path(), args=[*_FLAGS, *flags])


class PageUser:
    """
    Uses the page by the labels that a person reads.

    :param tab: playwright's page.
    :param address: what bringup or web printed.
    """

    def __init__(self, tab: Any, address: str) -> None:
        self.tab, self.address = tab, address
        self.page_errors: list[str] = []
        """What went wrong in the browser's own programs."""
        tab.on('pageerror', lambda error: self.page_errors.append(str(error)))

    def open(self) -> None:
        """Load the page and wait until the robot is there and can be moved."""
        self.tab.goto(self.address)
        self.wait_until_ready()

    def wait_until_ready(self) -> None:
        """Wait until the status shows that all programs are available, and the scene is drawn."""
        self.tab.locator('#status[data-level=ready]').wait_for()
        self.tab.locator('#plan:enabled').wait_for()
        self.tab.frame_locator('#scene').locator('canvas').first.wait_for()

    def field(self, label: str) -> Any:
        """Return the control that a label names."""
        return self.tab.locator(f'label:has(> span:text-is("{label}"))').locator(
            'select, input').first

    def press(self, button: str) -> None:
        """Press a button."""
        self.tab.get_by_role('button', name=button, exact=True).click()

    def press_at(self, item: str, button: str) -> None:
        """Press a button of an object of the scene."""
        self.tab.locator(f'[data-object="{item}"]').get_by_role(
            'button', name=button, exact=True).click()

    def choose(self, label: str, value: str) -> None:
        """Choose from a list."""
        self.field(label).select_option(value)

    def type_into(self, name: str, value: float) -> None:
        """Write a number into a field that has an accessible name, such as ``joint_1 [°]``."""
        field = self.tab.get_by_label(name, exact=True)
        field.fill(f'{value:g}')
        field.press('Enter')

    def slide(self, label: str, value: float) -> None:
        """Move a slider."""
        self.field(label).fill(f'{value:g}')

    def unfold(self, part: str) -> None:
        """Unfold a part of the panel."""
        fold = self.tab.locator(f'details:has(> summary:text-is("{part}"))')
        if fold.get_attribute('open') is None:
            fold.locator('> summary').click()

    def fold(self, part: str) -> None:
        """Fold a part of the panel."""
        fold = self.tab.locator(f'details:has(> summary:text-is("{part}"))')
        if fold.get_attribute('open') is not None:
            fold.locator('> summary').click()

    def wait_for_status(self, text: str) -> None:
        """Wait until the status line has a text in it."""
        self.tab.locator('#status-text', has_text=text).wait_for()

    def wait_for_result(self, text: str) -> None:
        """Wait for this result of the last request."""
        self.tab.locator('#result', has_text=text).wait_for()

    def wait_for_verdict(self, kind: str) -> str:
        """Wait until the goal is ``reachable``, ``collision`` or ``unreachable``; its words."""
        verdict = self.tab.locator(f'#verdict[data-kind={kind}]')
        verdict.wait_for()
        return str(verdict.inner_text())

    def go(self, state: str) -> None:
        """Move the robot to a named state: three clicks."""
        self.choose('Goal state', state)
        self.press('Plan & Execute')
        self.wait_for_result('arrived')

    def goal(self) -> Mapping[str, float]:
        """Return the goal's joint positions as the sliders have them [rad or m]."""
        self.unfold('Joints')
        radians = self.tab.get_by_label('Radians')
        radians.check()
        values = {slider.get_attribute('data-joint'): float(slider.input_value())
                  for slider in self.tab.locator('#joints input[type=range]').all()}
        radians.uncheck()
        return values

    def goal_after(self, before: Mapping[str, float]) -> Mapping[str, float]:
        """
        Return the goal's joint positions once they have left earlier ones and come to rest.

        :raises AssertionError: that is not so within 60 looks.
        """
        last = before
        for _ in range(60):
            now = self.goal()
            if now != before and now == last:
                return now
            last = now
            self.tab.wait_for_timeout(_LOOK)
        raise AssertionError('the goal stayed where it was, or never came to rest')

    def picture(self) -> Picture:
        """Return the scene as it is seen, (height, width, 3), 0..255."""
        data = self.tab.screenshot(clip=self.tab.locator('#view').bounding_box())
        return np.asarray(Image.open(io.BytesIO(data)).convert('RGB')).astype(np.int16)

    def wait_for_picture(self, requested: Callable[[Picture], bool]) -> Picture:
        """
        Wait until the scene is as expected, and return the picture.

        :raises AssertionError: it is not so within 60 looks.
        """
        for _ in range(60):
            picture = self.picture()
            if requested(picture):
                return picture
            self.tab.wait_for_timeout(_LOOK)
        raise AssertionError('the scene never looked as it should')

    def resting_picture(self) -> Picture:
        """Return the scene once it is still."""
        pictures = [self.picture()]

        def same(now: Picture) -> bool:
            pictures.append(now)
            return changed(pictures[-2], now) == 0

        return self.wait_for_picture(same)

    def pull_handle(self, pixels: float) -> None:
        """Pull the red arrow of the handle at the tool along itself, outwards."""
        picture = self.resting_picture()
        red, green, blue = (picture[..., index] for index in range(3))
        arrow = (red > 190) & (green < 110) & (blue > green + 18) & (blue < 170)
        others = ((blue > 200) & (red < 110)) | ((green > 190) & (red < 110))
        tip = _thickest(arrow)
        rows, columns = np.nonzero(arrow | others)
        away = np.array((tip[1] - columns.mean(), tip[0] - rows.mean()))
        away /= np.linalg.norm(away)
        corner = self.tab.locator('#view').bounding_box()
        start = np.array((corner['x'] + tip[1], corner['y'] + tip[0]))
        mouse = self.tab.mouse
        mouse.move(*start.tolist())
        mouse.down()
        for step in range(1, 6):
            mouse.move(*(start + away * pixels * step / 5).tolist())
        mouse.up()


def changed(first: Picture, other: Picture) -> int:
    """Return how many pixels of two pictures differ clearly."""
    return int((np.abs(first - other).max(axis=2) > _CLEARLY).sum())


def reddish(picture: Picture) -> int:
    """Return how many pixels are rather red."""
    return int((picture[..., 0] - picture[..., 1:].max(axis=2) > 60).sum())


def robot_is_seen(picture: Picture) -> bool:
    """Return whether there is more in a picture than the floor and its horizon."""
    height, width, _ = picture.shape
    middle = picture[height // 5:-height // 5, width // 5:-width // 5]
    shades = np.abs(middle - np.median(middle, axis=(0, 1))).max(axis=2)
    return int((shades > 2 * _CLEARLY).sum()) > 300


def printed_address(line: str) -> str:
    """Return the address in the line ``page: http://...``."""
    found = re.search(r'page: (http\S+)', line)
    assert found is not None, line
    return found[1]


def _thickest(mask: NDArray[np.bool_], size: int = 7) -> tuple[int, int]:
    """Return row and column around which most of a mask is set: an arrow's head."""
    assert mask.sum() > 20, 'there is no handle in the picture'
    sums = np.pad(mask.astype(int), ((1, 0), (1, 0))).cumsum(axis=0).cumsum(axis=1)
    counts = (sums[size:, size:] - sums[:-size, size:] - sums[size:, :-size]
              + sums[:-size, :-size])
    row, column = np.unravel_index(int(counts.argmax()), counts.shape)
    return int(row) + size // 2, int(column) + size // 2
