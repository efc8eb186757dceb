# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""
XML text as elements that remember their place, with readers for the values in them.

Elements of the standard library have no line; its parser has, and needs no further package.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
import math
from typing import NoReturn
from xml.parsers import expat

from armsim_ros.errors import ignored, Location, ModelError, nearest, Problem, Severity

LARGEST_TEXT = 20 << 20
# The standard library's functions for this bring half of its network protocols along.
_IN_TEXT = str.maketrans({'&': '&amp;', '<': '&lt;', '>': '&gt;'})
_IN_QUOTES = {
    **_IN_TEXT,
    **str.maketrans({'"': '&quot;', '\n': '&#10;', '\r': '&#13;', '\t': '&#9;'}),
}


@dataclass(frozen=True, slots=True, eq=False)
class XmlElement:
    """An element, its attributes, its children and its place."""

    tag: str
    attributes: dict[str, str]
    where: Location
    children: list[XmlElement] = field(default_factory=list)
    text: list[str] = field(default_factory=list)

    def all(self, tag: str) -> Iterator[XmlElement]:
        """Yield the children with a tag."""
        return (child for child in self.children if child.tag == tag)

    def first(self, tag: str) -> XmlElement | None:
        """Return the first child with a tag, None where there is none."""
        return next(self.all(tag), None)

    def get(self, name: str, default: str = '') -> str:
        """Return an attribute without the spaces around it."""
        return self.attributes.get(name, default).strip()

    @property
    def content(self) -> str:
        """The text inside, without the spaces around it."""
        return ''.join(self.text).strip()


class TextReport:
    """Collects what is wrong with a text, so that the user sees all of it at once."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def error(self, what: str, where: Location | None, allowed: str = '',
              remedy: str = '') -> None:
        """Record an error."""
        self.problems.append(Problem(what, where, allowed, remedy))

    def ignored(self, what: str, where: Location | None, remedy: str = '') -> None:
        """Record an error that upstream silently ignores."""
        self.problems.append(ignored(Problem(what, where, '', remedy)))

    def warning(self, what: str, where: Location | None, remedy: str = '') -> None:
        """Note what is odd, and what was done about it."""
        self.problems.append(Problem(what, where, '', remedy, Severity.WARNING))

    def info(self, what: str, where: Location | None) -> None:
        """Note what has no effect here."""
        self.problems.append(Problem(what, where, severity=Severity.INFO))

    def without(self, part: TextReport, what: str) -> bool:
        """
        Take over what was found in a part that upstream leaves out where it has an error.

        :param what: the part, such as "<visual> of link 'a'".
        :returns: whether it is left out.
        """
        for problem in part.problems:
            if problem.severity is Severity.ERROR:
                problem = ignored(replace(problem, what=f'{problem.what}; {what} is left out'))
            self.problems.append(problem)
        return bool(part.errors)

    def join_equal(self, link: str, links: str) -> None:
        """
        Join problems that differ only in their link.

        :param link: how they begin, with ``{}`` for the link.
        :param links: how the joined message begins, with ``{}`` for the links.
        """
        before, _, after = link.partition('{}')
        groups: dict[str, list[tuple[int, str]]] = {}
        for number, problem in enumerate(self.problems):
            name, sign, rest = problem.what.removeprefix(before).partition(after)
            if problem.what.startswith(before) and sign:
                groups.setdefault(rest, []).append((number, name))
        for rest, members in groups.items():
            if len(members) > 1:
                names = ', '.join(name for _, name in members)
                first = members[0][0]
                self.problems[first] = replace(
                    self.problems[first], what=f'{links.format(names)}{rest}')
                drop = {number for number, _ in members[1:]}
                self.problems = [problem for number, problem in enumerate(self.problems)
                                 if number not in drop]
                self.join_equal(link, links)
                return

    @property
    def errors(self) -> list[Problem]:
        """The errors alone."""
        return [problem for problem in self.problems if problem.severity is Severity.ERROR]

    def raise_errors(self) -> None:
        """
        Stop where there are errors.

        :raises ModelError: with all of them.
        """
        if self.errors:
            raise ModelError(self.errors)


def parse_xml(text: str, file: str) -> XmlElement:
    """
    Parse a text to its root element.

    :param file: the name that messages give.
    :raises ModelError: for a text that is not XML, or that defines entities.
    """
    if len(text) > LARGEST_TEXT:
        raise ModelError(Problem(f'the text is larger than {LARGEST_TEXT >> 20} MiB',
                                 Location(file)))
    return _Builder(file).build(text)


def xml_text(element: XmlElement, indent: str = '') -> str:
    """Return an element as text, each element inside it on a line of its own."""
    opening = ' '.join([element.tag, *(f'{name}={quoted(value)}'
                                       for name, value in element.attributes.items())])
    content = element.content.translate(_IN_TEXT)
    if not element.children:
        return (f'{indent}<{opening}>{content}</{element.tag}>\n' if content
                else f'{indent}<{opening}/>\n')
    inside = ''.join(xml_text(child, indent + '  ') for child in element.children)
    return f'{indent}<{opening}>{content}\n{inside}{indent}</{element.tag}>\n'


def quoted(value: str) -> str:
    """Return an attribute's value as written in XML, with its quotes."""
    return f'"{value.translate(_IN_QUOTES)}"'


class _Builder:
    """Builds elements from the parser's events."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._open: list[XmlElement] = []
        self._root: XmlElement | None = None
        self._parser = expat.ParserCreate('utf-8')
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.EntityDeclHandler = self._refuse_entity
        self._parser.buffer_text = True

    def build(self, text: str) -> XmlElement:
        try:
            self._parser.Parse(text.encode(), True)
        except expat.ExpatError as error:
            where = Location(self._file, error.lineno, error.offset + 1)
            remedy = _likely_cause(text, error, self._root)
            if self._open and not remedy:
                opened = self._open[-1]
                remedy = f'<{opened.tag}> of line {opened.where.line} is still open there'
            raise ModelError(Problem(
                f'this is not XML: {expat.ErrorString(error.code)}', where,
                remedy=remedy)) from None
        if self._root is None:
            raise ModelError(Problem('the file is empty', Location(self._file)))
        return self._root

    def _place(self) -> Location:
        return Location(self._file, self._parser.CurrentLineNumber,
                        self._parser.CurrentColumnNumber + 1)

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = XmlElement(tag, attributes, self._place())
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, tag: str) -> None:
        self._open.pop()

    def _text(self, data: str) -> None:
        if self._open:
            self._open[-1].text.append(data)

    def _refuse_entity(self, name: str, *_: object) -> NoReturn:
        raise ModelError(Problem(f"the text defines the entity '{name}'", self._place(),
                                 remedy='write the value where it is used'))


def _likely_cause(text: str, error: expat.ExpatError, root: XmlElement | None) -> str:
    """Return what the author of a text that is not XML probably did, '' where nothing fits."""
    name = expat.ErrorString(error.code)
    if name == 'junk after document element' and root is not None:
        owner = 'launch' if root.tag in ('node', 'include', 'rosparam', 'param') else 'robot'
        return (f'several elements are at the top, the first is <{root.tag}>: put them all '
                f'inside one <{owner}> ... </{owner}>')
    if name == 'not well-formed (invalid token)':
        lines = text.splitlines()
        line = lines[error.lineno - 1] if error.lineno <= len(lines) else ''
        before = line.encode()[:error.offset].decode(errors='ignore')
        if before.endswith(('"', "'")) and line[len(before):len(before) + 1].isidentifier():
            return (f"a space is missing between two attributes: "
                    f"'...{before[-12:]}{line[len(before):len(before) + 12]}...'")
    return ''


def read_numbers(element: XmlElement, name: str, count: int, report: TextReport,
                 default: tuple[float, ...]) -> tuple[float, ...]:
    """
    Return an attribute with several numbers.

    :param default: the value where the attribute is absent or wrong; an error is reported.
    """
    if name not in element.attributes:
        return default
    words = element.get(name).split()
    try:
        values = tuple(float(word) for word in words)
    except ValueError:
        values = ()
    if len(values) != count or not all(math.isfinite(value) for value in values):
        kind = 'a finite number' if count == 1 else f'{count} finite numbers'
        report.error(f"<{element.tag} {name}> is '{element.get(name)}'", element.where, kind)
        return default
    return values


def read_number(element: XmlElement, name: str, report: TextReport,
                default: float | None = None) -> float | None:
    """Return an attribute with a single number; an error is reported and gives the default."""
    if name not in element.attributes:
        return default
    values = read_numbers(element, name, 1, report, ())
    return values[0] if values else default


def unknown(kind: str, name: str, known: tuple[str, ...]) -> tuple[str, str]:
    """Return the message about an unknown name: the error, and a hint."""
    return f"{kind} '{name}' is not in the URDF", nearest(name, known)
