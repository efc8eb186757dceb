# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Errors in launch files, with the line of the user's file."""

from __future__ import annotations

from collections.abc import Sequence
import os
from pathlib import Path
import sys
import traceback
from types import FrameType, TracebackType
from typing import Any

from typing_extensions import Self

from armsim_ros.errors import ArmsimError, Location

_OWN_PACKAGE = str(Path(__file__).resolve().parent.parent) + os.sep


class LaunchError(ArmsimError):
    """
    A launch file cannot go on.

    :param where: the line of the user's file.
    """

    def __init__(self, what: str, where: Location | None = None) -> None:
        self.what, self.where = what, where
        super().__init__(f'{where}: {what}' if where else what)

    def at(self, where: Location | None) -> LaunchError:
        """Return the same error with a place, if it has none yet."""
        if self.where is not None or where is None:
            return self
        return type(self)(self.what, where)


class SubstitutionFailure(LaunchError):  # noqa: N818 - launch's own name
    """A substitution cannot be performed."""


class InvalidLaunchFileError(LaunchError):
    """A file is not a launch file."""


class MissingPackageError(KeyError):
    """
    A package is not found; a KeyError because launch files catch that.

    :param package: its name.
    """

    def __init__(self, package: str, text: str = '') -> None:
        self.package = package
        super().__init__(text or f"package '{package}' not found")

    def __str__(self) -> str:
        """Return the text without the quotes that a KeyError puts around it."""
        return str(self.args[0])


class MissingArgumentsError(ArmsimError):
    """
    Arguments without a default were not given.

    :param arguments: (name, choices) of each.
    """

    def __init__(self, arguments: Sequence[tuple[str, Sequence[str]]]) -> None:
        self.arguments = tuple(arguments)
        super().__init__('\n'.join(self.lines()))

    def lines(self) -> list[str]:
        """Return a line for each."""
        return [f'needs argument: {name} choices={",".join(choices)}'
                for name, choices in self.arguments]


#: Modules of programs for robots -> their distribution, where that has another name.
_DISTRIBUTIONS = {
    'OpenGL': 'PyOpenGL', 'PIL': 'pillow', 'cv2': 'opencv-python-headless',
    'dynamixel_sdk': 'dynamixel-sdk', 'serial': 'pyserial', 'skimage': 'scikit-image',
    'sklearn': 'scikit-learn', 'usb': 'pyusb', 'yaml': 'PyYAML', 'zmq': 'pyzmq',
}


def missing_module_text(module: str, sources: Path | None = None,
                        package: Path | None = None) -> str:
    """
    Return what to do about a Python module that a program lacks.

    :param sources: folder of the module that is to hold it, where the workspace has that.
    :param package: folder of the ROS package of its name, where the workspace has that.
    """
    top, *rest = module.split('.')
    if package is not None and any((package / kind).is_dir() for kind in ('msg', 'srv', 'action')):
        return (f"Python module '{module}' is missing: the messages of '{package}' are not built; "
                "link that folder into interfaces/ of armsim_ros's source tree and run `make env` "
                'there, or build the workspace with colcon in a ROS installation')
    if rest and sources is not None:
        others = sorted(file.name for file in sources.joinpath(*rest[:-1]).glob(f'{rest[-1]}.*'))
        return (f"Python module '{module}' is missing in '{sources}' itself"
                + (f'; it is there for other systems or versions of Python: {", ".join(others)}'
                   if others else ''))
    return (f"Python module '{module}' is missing: clone the ROS package that has it into src/ of "
            f"the workspace, or install it ('pip install {_DISTRIBUTIONS.get(top, top)}')")


class StoppedError(BaseException):
    """
    A launch file does not come to an end; no ``except Exception`` of a user's file catches it.

    :param what: the reason.
    """


def failure_of(error: BaseException, file: str) -> LaunchError:
    """
    Return an exception of a user's file with its file and line.

    :param file: the launch file, where no other file of the user's is in the traceback.
    """
    if isinstance(error, LaunchError):
        return error if error.where else error.at(user_place(error.__traceback__))
    where = user_place(error.__traceback__) or Location(file)
    if isinstance(error, SyntaxError):
        return LaunchError(f'SyntaxError: {error.msg}',
                             Location(error.filename or file, error.lineno, error.offset))
    if isinstance(error, KeyError) and _raised_in(error.__traceback__, 'os.py'):
        return LaunchError(f'environment variable {error.args[0]} is not set', where)
    if isinstance(error, FileNotFoundError) and error.filename is not None:
        return LaunchError(f"file '{os.fsdecode(error.filename)}' does not exist", where)
    if isinstance(error, EOFError):
        return LaunchError('the launch file asks for an answer, but there is no terminal; '
                           'run it in a terminal, or pipe the answers in', where)
    if isinstance(error, ArmsimError):
        return LaunchError(str(error), where)
    text = str(error)
    return LaunchError(f'{type(error).__name__}{": " + text if text else ""}', where)


def import_place(error: ImportError, file: str) -> Location:
    """Return the user's line that imports a missing module."""
    return user_place(error.__traceback__) or Location(file)


def user_place(trace: TracebackType | None) -> Location | None:
    """Return the innermost line of a traceback in the user's code, None if there is none."""
    found = None
    for frame in traceback.extract_tb(trace):
        if _is_users(frame.filename):
            found = Location(frame.filename, frame.lineno)
    return found


def _is_users(name: str) -> bool:
    if name.startswith(('<', _OWN_PACKAGE)) or os.sep + 'site-packages' + os.sep in name:
        return False
    return not name.startswith(os.path.dirname(os.__file__) + os.sep)


def _raised_in(trace: TracebackType | None, file: str) -> bool:
    frames = traceback.extract_tb(trace)
    names = (file, f'<frozen {file[:-3]}>')
    return bool(frames) and os.path.basename(frames[-1].filename) in names


_OWN_FOLDER = str(Path(__file__).resolve().parent) + os.sep


def calling_place() -> Location | None:
    """Return the line of the launch file, or of the user's other code, that is being run."""
    frame: FrameType | None = sys._getframe(1)
    while frame is not None:
        name = frame.f_code.co_filename
        if not name.startswith((_OWN_FOLDER, '<')):
            return Location(name, frame.f_lineno)
        frame = frame.f_back
    return None


class Placed:
    """Remembers the line of the launch file that made it."""

    where: Location | None = None

    def __new__(cls, *_args: Any, **_kwargs: Any) -> Self:
        """Make it and remember the line."""
        made = super().__new__(cls)
        made.where = calling_place()
        return made
