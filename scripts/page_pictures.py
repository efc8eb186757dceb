# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
Makes the pictures of the page in docs/images from a robot that runs, in headless Chromium.

    python scripts/page_pictures.py [first three_clicks collision path two_arms panda]

Ends with an error where the page does not come up or does not do what the picture shows.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
import io
from pathlib import Path
import re
import sys
import tempfile
from typing import Any

from PIL import Image
from playwright.sync_api import Browser, Locator, sync_playwright, ViewportSize

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / 'test' / 'support')]

from public_robots import public_urdf  # noqa: E402

from armsim_ros.testing.page_user import launch_chromium, PageUser, printed_address, robot_is_seen  # noqa: E402
from armsim_ros.testing.program import private_domain, start_program  # noqa: E402
from armsim_ros.testing.robot_user import READY  # noqa: E402
from armsim_ros.tools.generate_config.main import generate_config  # noqa: E402

IMAGES = ROOT / 'docs' / 'images'
SIZE: ViewportSize = {'width': 1200, 'height': 760}
#: For what the page shows after a while [ms]; a machine without a graphics card is slow.
PATIENCE = 120_000
#: Width of animations [px].
FILM_WIDTH = 800


def main() -> None:
    """Make the pictures that are named, or all."""
    of_sunday = {'first': first, 'three_clicks': three_clicks, 'collision': collision,
                 'path': path}
    of_others = {'two_arms': two_arms, 'panda': panda}
    parser = argparse.ArgumentParser(description='Make the pictures of the page in docs/images.')
    parser.add_argument('names', nargs='*', metavar='PICTURE')
    wanted = parser.parse_args().names or [*of_sunday, *of_others]
    IMAGES.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        browser = launch_chromium(playwright)
        sunday = [of_sunday[name] for name in wanted if name in of_sunday]
        if sunday:
            with robot() as address:
                for make in sunday:
                    scheme = 'dark' if make is path else 'light'
                    make(open_page(browser, address, color_scheme=scheme))
        for name in wanted:
            if name in of_others:
                of_others[name](browser)
        browser.close()


def first(page: PageUser) -> None:
    """Show what a newcomer sees, and a goal."""
    page.choose('Goal state', 'scan_food')
    page.wait_for_verdict('reachable')
    save(page, 'page_first')


def three_clicks(page: PageUser) -> None:
    """Show a goal state chosen, planned and executed, as an animation."""
    page.slide('Speed', 3)  # a picture takes seconds without a graphics card
    page.field('Speed').blur()
    film = Film(page)
    film.take(1200)
    film.mark(page.field('Goal state'))
    film.take(900)
    page.choose('Goal state', 'scan_food')
    page.wait_for_verdict('reachable')
    page.resting_picture()
    film.take(1200)
    film.mark(page.tab.get_by_role('button', name='Plan & Execute', exact=True))
    film.take(900)
    page.press('Plan & Execute')
    film.mark(None)
    while not page.tab.locator('#result', has_text='arrived').count():
        film.take(250)
    page.resting_picture()
    film.take(2500)
    film.save('page_three_clicks')


class Film:
    """
    Pictures of the page, a ring around what is clicked, as an animated GIF.

    :param page: is filmed.
    """

    def __init__(self, page: PageUser) -> None:
        self._page = page
        self._pictures: list[Image.Image] = []
        self._durations: list[int] = []

    def mark(self, control: Locator | None) -> None:
        """Draw a ring around a control, or around none any more."""
        self._page.tab.evaluate("document.getElementById('ring')?.remove()")
        if control is None:
            return
        control.scroll_into_view_if_needed()
        control.evaluate("""control => {
            const box = control.getBoundingClientRect(), ring = document.createElement('div');
            ring.id = 'ring';
            ring.style.cssText = `position: fixed; z-index: 9999; pointer-events: none;
                left: ${box.left - 6}px; top: ${box.top - 6}px; width: ${box.width + 6}px;
                height: ${box.height + 6}px; border: 3px solid #e8590c; border-radius: 9px`;
            document.body.append(ring);
        }""")

    def take(self, duration: int) -> None:
        """Add a picture that is shown for a while [ms]; the same as before lasts longer."""
        data = self._page.tab.screenshot()
        picture = Image.open(io.BytesIO(data)).convert('RGB')
        picture = picture.resize((FILM_WIDTH, picture.height * FILM_WIDTH // picture.width),
                                 Image.Resampling.LANCZOS)
        if self._pictures and picture.tobytes() == self._pictures[-1].tobytes():
            self._durations[-1] += duration
            return
        self._pictures.append(picture)
        self._durations.append(duration)

    def save(self, name: str) -> None:
        """Write the file with a palette for all pictures, and close the page."""
        palette = self._pictures[len(self._pictures) // 2].quantize(96)
        frames = [picture.quantize(palette=palette, dither=Image.Dither.NONE)
                  for picture in self._pictures]
        file = IMAGES / f'{name}.gif'
        frames[0].save(file, save_all=True, append_images=frames[1:], loop=0, optimize=True,
                       duration=self._durations, disposal=1)
        print(f'{file.relative_to(ROOT)}: {len(frames)} pictures, {file.stat().st_size} bytes')
        close(self._page, name)


def collision(page: PageUser) -> None:
    """Show the arm folded into itself."""
    page.unfold('Joints')
    for joint, angle in (('joint_2', 88), ('joint_3', 155)):
        page.type_into(f'{joint} [°]', angle)
    page.wait_for_verdict('collision')
    save(page, 'page_collision')


def path(page: PageUser) -> None:
    """Show a planned path with its curves, on a dark system."""
    page.choose('Goal state', 'scan_face2')
    page.press('Plan')
    page.wait_for_result('planned')
    page.unfold('Motion')
    duration = float(page.field('Time').get_attribute('max'))
    page.slide('Time', 0.55 * duration)
    page.tab.locator('#part-motion').evaluate('part => part.scrollIntoView()')
    save(page, 'page_path')


def two_arms(browser: Browser) -> None:
    """Show a cell of two arms, the left one where it was sent."""
    with robot('robot:=two_bots') as address:
        page = open_page(browser, address)
        page.go('ready')
        save(page, 'page_two_arms')


def panda(browser: Browser) -> None:
    """Show a Panda with the meshes and the colours of its maker."""
    with tempfile.TemporaryDirectory() as folder:
        generate_config(public_urdf('panda'), Path(folder, 'panda'))
        with robot(f'robot:={folder}/panda') as address:
            page = open_page(browser, address)
            page.go('ready')
            save(page, 'page_panda')


@contextmanager
def robot(*arguments: str) -> Iterator[str]:
    """Run a robot and its page as a newcomer does; the page's address."""
    with private_domain() as domain, \
            start_program('bringup', domain, 'web:=true', *arguments) as bringup:
        address = printed_address(bringup.wait_for_line('page: http', 120))
        bringup.wait_for_line(re.escape(READY), 120)
        yield address


def open_page(browser: Browser, address: str, **options: Any) -> PageUser:
    """Open the page and wait until the robot is seen."""
    window = browser.new_context(viewport=SIZE, **options)
    window.set_default_timeout(PATIENCE)
    page = PageUser(window.new_page(), address)
    page.open()
    page.wait_for_picture(robot_is_seen)
    return page


def save(page: PageUser, name: str) -> None:
    """Save the picture as soon as nothing in it changes any more, and close the page."""
    page.resting_picture()
    data = page.tab.screenshot()
    picture = Image.open(io.BytesIO(data)).convert('RGB').quantize(256, dither=Image.Dither.NONE)
    picture.save(IMAGES / f'{name}.png', optimize=True)
    print(f'docs/images/{name}.png', flush=True)
    close(page, name)


def close(page: PageUser, name: str) -> None:
    """Close the page; an error of its own ends the program."""
    page.tab.context.close()
    if page.page_errors:
        raise SystemExit(f'{name}: {page.page_errors}')


if __name__ == '__main__':
    main()
