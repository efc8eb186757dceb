# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Every error of armsim_ros: what is wrong, where, what is allowed, what to do."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
import difflib
from enum import Enum, IntEnum

#: Exit status of a program after a wrong command line or configuration.
USAGE_STATUS = 2
#: What is longer, or comes after so many others, gets no hint: the search would take too long.
LONGEST_NAME, MOST_NAMES = 200, 1000


class Severity(Enum):
    """
    How much a problem matters: an error stops the program, the others do not.

    CHANGED marks what is read and means something else here, INFO what is not used here.
    """

    ERROR = 'error'
    WARNING = 'warning'
    CHANGED = 'changed'
    INFO = 'info'


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a text that the user wrote; line and column count from 1."""

    file: str
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        """Return ``file:line:column`` in the form that editors jump to."""
        numbers = [str(n) for n in (self.line, self.column) if n is not None]
        return ':'.join([self.file, *numbers])


@dataclass(frozen=True, slots=True)
class Problem:
    """
    An error in the user's input.

    :param what: what is wrong, naming the value.
    :param where: the place, or None where there is none.
    :param allowed: the values that would be right, as a phrase.
    :param remedy: what to do next, as a phrase.
    :param strict: whether it is an error in strict mode, though upstream
        goes on without a word.
    """

    what: str
    where: Location | None = None
    allowed: str = ''
    remedy: str = ''
    severity: Severity = field(default=Severity.ERROR)
    strict: bool = False

    def __str__(self) -> str:
        """Return a line: place, error, what is allowed, what to do."""
        text = self.what.rstrip('.')
        if self.allowed:
            text += f'; allowed: {self.allowed}'
        if self.remedy:
            text += f'; {self.remedy}'
        return f'{self.where}: {text}' if self.where else text


def ignored(problem: Problem) -> Problem:
    """Return an error as the warning that it is where upstream ignores it."""
    if problem.severity is not Severity.ERROR:
        return problem
    return replace(problem, severity=Severity.WARNING, strict=True)


def strictly(problem: Problem) -> Problem:
    """Return a problem with its severity in strict mode."""
    return replace(problem, severity=Severity.ERROR) if problem.strict else problem


class ArmsimError(Exception):
    """Root of all errors that armsim_ros raises on purpose; its text is for the user."""


class ConfigError(ArmsimError):
    """
    The user's files do not describe a robot that can run.

    :param problems: every error found, at least one.
    """

    def __init__(self, problems: Problem | Iterable[Problem]) -> None:
        """Keep the problems; the text is a line per problem."""
        found = (problems,) if isinstance(problems, Problem) else tuple(problems)
        if not found:
            raise ValueError('ConfigError needs at least one problem')
        self.problems: tuple[Problem, ...] = found
        super().__init__('\n'.join(dict.fromkeys(str(problem) for problem in found)))


class ModelError(ConfigError):
    """The URDF or SRDF text is wrong, or the two do not belong together."""


class ResourceError(ArmsimError):
    """A file or package that was asked for is not there."""


class SimulationError(ArmsimError):
    """The physics cannot go on, or was asked for what it does not have."""


class TrajectoryError(ArmsimError):
    """Arrays are not a trajectory: a shape or a number is wrong."""


class ControllerError(ArmsimError):
    """A controller rejects a request, or cannot complete it."""


class MoveItErrorCode(IntEnum):
    """Constants of ``moveit_msgs/msg/MoveItErrorCodes``."""

    UNDEFINED = 0
    SUCCESS = 1
    FAILURE = 99999
    PLANNING_FAILED = -1
    INVALID_MOTION_PLAN = -2
    MOTION_PLAN_INVALIDATED_BY_ENVIRONMENT_CHANGE = -3
    CONTROL_FAILED = -4
    UNABLE_TO_AQUIRE_SENSOR_DATA = -5
    TIMED_OUT = -6
    PREEMPTED = -7
    START_STATE_IN_COLLISION = -10
    START_STATE_VIOLATES_PATH_CONSTRAINTS = -11
    GOAL_IN_COLLISION = -12
    GOAL_VIOLATES_PATH_CONSTRAINTS = -13
    GOAL_CONSTRAINTS_VIOLATED = -14
    INVALID_GROUP_NAME = -15
    INVALID_GOAL_CONSTRAINTS = -16
    INVALID_ROBOT_STATE = -17
    INVALID_LINK_NAME = -18
    INVALID_OBJECT_NAME = -19
    FRAME_TRANSFORM_FAILURE = -21
    COLLISION_CHECKING_UNAVAILABLE = -22
    ROBOT_STATE_STALE = -23
    SENSOR_INFO_STALE = -24
    COMMUNICATION_FAILURE = -25
    START_STATE_INVALID = -26
    GOAL_STATE_INVALID = -27
    UNRECOGNIZED_GOAL_TYPE = -28
    CRASH = -29
    ABORT = -30
    NO_IK_SOLUTION = -31


class PlanningError(ArmsimError):
    """
    A planning request cannot be answered.

    :param code: a value of :class:`MoveItErrorCode`.
    :param message: names links, joints, objects and numbers.
    :param source: the stage that found it.
    :param contacts: what touches in the state that it is about, if it is about a state.
    """

    def __init__(
        self, code: int, message: str, source: str = '', contacts: Sequence[object] = ()
    ) -> None:
        super().__init__(message)
        self.code, self.source = code, source
        self.contacts = tuple(contacts)


def nearest(name: str, known: Sequence[str]) -> str:
    """
    Return a hint that names the known word nearest to a wrong word.

    :param name: the word that was given.
    :param known: all words that would be right.
    :returns: ``did you mean 'x'?`` or an empty text.
    """
    if len(name) > LONGEST_NAME:
        return ''
    near = [word for word in known if len(word) <= LONGEST_NAME and word != name][:MOST_NAMES]
    same = [word for word in near if word.lower() == name.lower()]
    hits = same or difflib.get_close_matches(name, near, n=max(1, len(near)), cutoff=0.6)
    # Of equally near words the word with the same letters: two of them were swapped in typing.
    hits.sort(key=lambda hit: sorted(hit) != sorted(name))
    return f"did you mean '{hits[0]}'?" if hits else ''


def extras_hint(*extras: str) -> str:
    """Return the commands that install optional dependencies, by the names of their extras."""
    return (f"make env EXTRAS=\"{' '.join(extras)}\" in the source tree, or "
            f"pip install 'armsim_ros[{','.join(extras)}]'")
