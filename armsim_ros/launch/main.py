# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The launch program: shows, dry-runs or runs the launch file of its command line."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, MutableMapping, Sequence
from contextlib import contextmanager, redirect_stdout
from dataclasses import dataclass, field
import os
from pathlib import Path
import sys

from armsim_ros.cli.arguments import UsageError
from armsim_ros.errors import ArmsimError, nearest, USAGE_STATUS
from armsim_ros.launch.api.configuration import declared_arguments, DeclareLaunchArgument
from armsim_ros.launch.api.context import (
    describe_text,
    LaunchContext,
    LaunchDescriptionEntity,
    replace_environment,
)
from armsim_ros.launch.api.description import (
    AnyLaunchDescriptionSource,
    format_entities,
    IncludeLaunchDescription,
)
from armsim_ros.launch.engine import Engine, watchdog
from armsim_ros.launch.failures import MissingPackageError, StoppedError
from armsim_ros.launch.files import read_launch_file
from armsim_ros.launch.lookup import current_lookup, looking_with, Lookup, make_lookup, stand_in_of
from armsim_ros.launch.names import importable
from armsim_ros.launch.overlay import environment_with, overlay_folder, write_overlay
from armsim_ros.launch.process_spec import is_known, ProcessSpec
from armsim_ros.launch.report import Report
from armsim_ros.launch.runner import DryRunner, ProcessRunner, Runner
from armsim_ros.packages import MARKERS, sourced_prefixes, split_path

#: What a sourced installation of Jazzy sets.
ROS_VARIABLES = {'ROS_DISTRO': 'jazzy', 'ROS_VERSION': '2', 'ROS_PYTHON_VERSION': '3'}


def main(argv: Sequence[str] | None = None) -> int:
    """
    Run a launch file, or show what it would start.

    :param argv: the words after the program's name; those of this process where None.
    :returns: 0 after Ctrl-C or a good end, 1 when a required process failed, 2 for errors
        before the start.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    if not words or {'-h', '--help'} & set(words):
        print(USAGE)
        return 0 if words else USAGE_STATUS
    try:
        requested = parse_words(words)
    except ArmsimError as error:
        print(f'launch: {error}', file=sys.stderr)
        return USAGE_STATUS
    _complete_environment(os.environ)
    launch = Launch(requested)
    if requested.show_arguments:
        return launch.show_arguments()
    if requested.print_description:
        return launch.print_description()
    if requested.dry:
        return launch.dry_run()
    real = _real_ros2()
    if real:
        # Where the real launch is installed, it runs the file; the overlay gives it our programs.
        folder = write_overlay(overlay_folder())
        os.execve(real, [real, 'launch', *words], environment_with(folder))
    return launch.run()


def _complete_environment(environment: MutableMapping[str, str]) -> None:
    """Set what sourcing a ROS installation sets; launch files and their programs rely on it."""
    for name, value in ROS_VARIABLES.items():
        environment.setdefault(name, value)
    programs = str(Path(sys.executable).parent)
    paths = environment.get('PATH', os.defpath).split(os.pathsep)
    if programs not in paths:
        # The environment need not be active for its xacro and ros2 to be found.
        environment['PATH'] = os.pathsep.join([*paths, programs])


def _real_ros2() -> str:
    """Return ``ros2`` of a sourced ROS installation with launch, '' if there is none."""
    for prefix in sourced_prefixes():
        program = prefix / 'bin' / 'ros2'
        if (prefix / MARKERS / 'ros2launch').is_file() and os.access(program, os.X_OK):
            return str(program)
    return ''


USAGE = """usage: armsim launch PACKAGE FILE [NAME:=VALUE ...]
       armsim launch PATH [NAME:=VALUE ...]

Run a launch file (.launch.py, .launch.xml, .launch.yaml, ROS 1 .launch) unchanged. Programs of
Gazebo, ros2_control and MoveIt are replaced by those of this package; others run if they are
installed, or from the sources of a Python package.

options:
  -s, --show-args          print the arguments of the launch file
  -n, --dry-run            start nothing; print the processes and what is missing
  -p, --print-description  print the launch file as a tree, not evaluated
  -d, --debug              accepted, without effect
  -a, --show-all-subprocesses-output
                           show all output (always on here)
  --launch-prefix COMMAND  put a command before every program, such as 'nice'
  --launch-prefix-filter REGEX
                           only before the programs whose names it matches
  packages_path:=DIR[:DIR] folders that are searched first for packages"""

#: Option -> the field that it sets, '' of an option that changes nothing here.
_FLAGS = {
    '-s': 'show_arguments', '--show-args': 'show_arguments', '--show-arguments': 'show_arguments',
    '-n': 'dry', '--dry-run': 'dry',
    '-p': 'print_description', '--print': 'print_description',
    '--print-description': 'print_description',
    **dict.fromkeys(('-d', '--debug', '-a', '--show-all-subprocesses-output',
                     '--noninteractive'), ''),
}
#: Options that set the launch configurations of their names.
_SETTINGS = ('--launch-prefix', '--launch-prefix-filter')
ENDINGS = ('launch.py', '_launch.py', 'launch.xml', 'launch.yaml', 'launch.yml', '.launch')


@dataclass
class LaunchWords:
    """
    The command line, parsed.

    :param arguments: in the order of the command line, the last of a name counts.
    """

    file: Path
    lookup: Lookup
    arguments: dict[str, str] = field(default_factory=dict)
    show_arguments: bool = False
    dry: bool = False
    print_description: bool = False


def parse_words(words: Sequence[str]) -> LaunchWords:
    """
    Parse the words after ``launch``.

    :raises UsageError: where they cannot be understood, or the file does not exist.
    """
    places: list[str] = []
    arguments: dict[str, str] = {}
    flags: dict[str, bool] = {}
    rest = iter(words)
    for word in rest:
        name, sign, value = word.partition(':=')
        option, is_whole, setting = word.partition('=')
        if option in _SETTINGS:
            found = setting if is_whole else next(rest, None)
            if found is None:
                raise UsageError(f"'{option}' needs a value")
            arguments[option.lstrip('-')] = found
        elif sign and not word.startswith('-'):
            if not name:
                raise UsageError(f"cannot read '{word}': arguments are written name:=value")
            arguments[name] = value
        elif word in _FLAGS:
            flags[_FLAGS[word]] = True
        elif word.startswith('-') and len(word) > 2 and not word.startswith('--') and all(
                f'-{letter}' in _FLAGS for letter in word[1:]):
            flags.update({_FLAGS[f'-{letter}']: True for letter in word[1:]})
        elif word.startswith('-'):
            hint = nearest(word, (*_FLAGS, *_SETTINGS)) or USAGE
            raise UsageError(f"unknown option '{word}'; {hint}")
        else:
            places.append(word)
    if not places:
        raise UsageError(f'no launch file is named\n{USAGE}')
    if len(places) > 2:
        raise UsageError(f"cannot read '{places[2]}': arguments are written name:=value")
    path = split_path(arguments.get('packages_path', ''))
    file, lookup = _find(places, path)
    flags.pop('', None)
    return LaunchWords(file, lookup, arguments, **flags)


def _find(places: Sequence[str], path: tuple[Path, ...]) -> tuple[Path, Lookup]:
    first = Path(places[0]).expanduser()
    if len(places) == 1:
        if first.is_file():
            file = first.resolve() if first.is_symlink() else first.absolute()
            return first.absolute(), make_lookup(path, [first.absolute(), file])
        if first.is_dir():
            raise UsageError(f"'{first}' is a folder; {_choice(_launch_files(first))}")
        raise UsageError(f"launch file '{places[0]}' does not exist"
                         + ('' if first.suffix else '; with a package: armsim launch PACKAGE '
                            'FILE'))
    package, name = places
    lookup = make_lookup(path, [first.absolute()] if first.is_dir() else [])
    folder = first.absolute() if first.is_dir() and (first / 'package.xml').is_file() else None
    if folder is None:
        try:
            folder = lookup.share(package)
        except MissingPackageError as error:
            raise UsageError(str(error)) from None
    # Links may lead to a file in two ways.
    found = list({file.resolve(): file for file in _launch_files(folder)
                  if file.name == name}.values())
    if not found and (stand_in := stand_in_of(Path(package, 'launch', name))):
        found = [stand_in]
    if not found:
        files = list(_launch_files(folder))
        hint = nearest(name, [file.name for file in files])
        raise UsageError(f"package '{package}' ({folder}) has no launch file '{name}'; "
                         f'{hint or _choice(files)}')
    if len(found) > 1:
        raise UsageError(f"package '{package}' has several files '{name}': "
                         f"{', '.join(map(str, found))}; name one by its path")
    return found[0], make_lookup(path, [found[0]])


def _launch_files(folder: Path) -> Iterator[Path]:
    # The folder of a package that is not built may consist of links.
    found, seen = [], set()
    for place, folders, names in os.walk(folder, followlinks=True):
        real = os.path.realpath(place)
        if real in seen:
            folders.clear()
            continue
        seen.add(real)
        # An environment in a checkout holds the installed copy of its files.
        folders[:] = [name for name in folders if not name.startswith('.')
                      and not Path(place, name, 'pyvenv.cfg').is_file()]
        found += [Path(place, name) for name in names]
    for file in sorted(found):
        if file.is_file() and (file.name.endswith(ENDINGS) or (file.parent.name == 'launch'
                               and file.suffix in ('.py', '.xml', '.yaml'))):
            yield file


def _choice(files: Iterator[Path] | Sequence[Path]) -> str:
    names = ', '.join(dict.fromkeys(file.name for file in files))
    return f'there are: {names}' if names else 'it has none'


#: How deep includes are read to show their arguments.
_SHOWN_DEPTH = 6


class Launch:
    """
    A launch file and its arguments.

    :param words: what the user asked for.
    """

    def __init__(self, words: LaunchWords) -> None:
        self._words = words

    def dry_run(self) -> int:
        """Print what would be started and what is missing; return 0, or 2 if something is."""
        output = sys.stdout

        def write(line: str) -> None:
            print(line, file=output, flush=True)

        report = Report(dry=True, write=write)
        # The user's own output does not belong to the plan.
        with redirect_stdout(sys.stderr):
            self._evaluate(report, DryRunner(report, is_known))
        if not report.lines and not report.failures:
            write('nothing to start')
        return USAGE_STATUS if report.failures else 0

    def show_origins(self, ours: Collection[str]) -> int:
        """
        Print where each program of the file comes from.

        :param ours: ``PACKAGE/PROGRAM`` of the overlay.
        """
        def known(spec: ProcessSpec) -> bool:
            node = spec.node
            found = current_lookup().program(node.package, node.executable) if node else None
            origin = 'ours' if spec.label in ours else str(found or 'PATH' if found or not node
                                                           else 'not installed')
            print(f'{spec.label}: {origin}', file=output)
            return True

        output = sys.stdout
        report = Report(dry=True)
        with redirect_stdout(sys.stderr):
            self._evaluate(report, DryRunner(report, known))
        return USAGE_STATUS if report.failures else 0

    def run(self) -> int:
        """Run it; return 0 after success or Ctrl-C, 1 after a failure, 2 after an error."""
        report = Report(dry=False)
        status = self._evaluate(report, ProcessRunner(report))
        return USAGE_STATUS if report.failures else status

    def show_arguments(self) -> int:
        """Print the arguments of the file and of those that it includes."""
        report = Report(dry=False)
        with self._evaluating(report), watchdog():
            shown: dict[str, DeclareLaunchArgument] = {}
            context = LaunchContext(argv=())
            context.launch_configurations.update(self._words.arguments)
            self._collect(read_launch_file(self._words.file).entities, context, shown, 0)
            print("Arguments (pass arguments as '<name>:=<value>'):")
            if not shown:
                print('\n    No arguments.')
            for argument in shown.values():
                print(f'\n    {_argument_text(argument)}')
        return USAGE_STATUS if report.failures else 0

    def print_description(self) -> int:
        """Print the file as a tree."""
        report = Report(dry=False)
        with self._evaluating(report), watchdog():
            print('\n'.join(format_entities(read_launch_file(self._words.file).entities)))
        return USAGE_STATUS if report.failures else 0

    def _evaluate(self, report: Report, runner: Runner) -> int:
        status = 0
        with self._evaluating(report):
            context = LaunchContext(argv=sys.argv[1:])
            context.launch_configurations.update(self._words.arguments)
            source = AnyLaunchDescriptionSource(str(self._words.file))
            status = Engine(context, runner, report).run(IncludeLaunchDescription(source))
        return status

    def _collect(self, entities: Iterable[LaunchDescriptionEntity], context: LaunchContext,
                 shown: dict[str, DeclareLaunchArgument], depth: int) -> None:
        for argument in declared_arguments(entities):
            shown.setdefault(argument.name, argument)
            if (argument.default_value is not None
                    and argument.name not in context.launch_configurations):
                with _ignoring_failures():
                    argument.execute(context)
        if depth >= _SHOWN_DEPTH:
            return
        for include in _includes(entities):
            with _ignoring_failures():
                description = include.launch_description_source.get_launch_description(context)
                self._collect(description.entities, context, shown, depth + 1)

    @contextmanager
    def _evaluating(self, report: Report) -> Iterator[None]:
        """Let the file import what it needs, and report what the user's code raises."""
        environment = dict(os.environ)
        try:
            with looking_with(self._words.lookup), importable(self._words.lookup):
                yield
        except (StoppedError, Exception) as error:  # noqa: BLE001 - anything that it raises
            report.failure(error, str(self._words.file))
        except SystemExit as end:
            if end.code not in (None, 0):
                report.failure(RuntimeError(f'the launch file ended itself: {end.code}'),
                               str(self._words.file))
        finally:
            replace_environment(environment)


def _includes(entities: Iterable[LaunchDescriptionEntity]) -> Iterator[IncludeLaunchDescription]:
    for entity in entities:
        if isinstance(entity, IncludeLaunchDescription):
            yield entity
        yield from _includes(entity.describe_sub_entities())
        for _, inside in entity.describe_conditional_sub_entities():
            yield from _includes(inside)


def _argument_text(argument: DeclareLaunchArgument) -> str:
    lines = [f"'{argument.name}':"]
    text = ' '.join(argument.description.split())
    if argument.choices:
        text += f' Valid choices are: {argument.choices}'
    lines.append(f'    {text}')
    if argument.default_value is not None:
        lines.append(f'    (default: {describe_text(argument.default_value)})')
    return '\n    '.join(lines)


@contextmanager
def _ignoring_failures() -> Iterator[None]:
    """Go on: what cannot be read has no arguments to show; a run reports why."""
    try:
        yield
    except Exception:  # noqa: BLE001 - anything that the user's code raises
        return
