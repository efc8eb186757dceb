# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""``ros2 pkg``."""

from __future__ import annotations

from argparse import Namespace
from xml.etree import ElementTree

from armsim_ros2.errors import CliError, hint
from armsim_ros2.packages import prefix_of, programs_of, resources
from armsim_ros2.parsing import argument, flag, Verb

_NOT_FOUND = "Package not found: '{}'"


def _list(options: Namespace) -> None:
    print(*resources('packages'), sep='\n')


def _prefix(options: Namespace) -> None:
    prefix = prefix_of(options.package_name, _NOT_FOUND)
    print(prefix / 'share' / options.package_name if options.share else prefix)


def _executables(options: Namespace) -> None:
    names = [options.package_name] if options.package_name else list(resources('packages'))
    for name in names:
        for file in programs_of(name):
            print(file if options.full_path else f'{name} {file.name}')


def _xml(options: Namespace) -> None:
    share = prefix_of(options.package_name, _NOT_FOUND) / 'share' / options.package_name
    file = share / 'package.xml'
    if not file.is_file():
        raise CliError(f"Package XML manifest not found: '{file}'")
    tree = ElementTree.parse(file)
    if options.tag is None:
        ElementTree.dump(tree)
        return
    elements = tree.getroot().findall(options.tag)
    if not elements:
        raise CliError(f"XML tag not found: '{options.tag}'"
                       f'{hint(options.tag, {child.tag for child in tree.getroot()})}')
    for element in elements:
        print(element.text)


_package = argument('package_name', help='name of the package')

VERBS = {
    'executables': Verb('print the programs of one package or of all', _executables, [
        argument('package_name', nargs='?', help='name of the package'),
        flag('--full-path', about='print the paths of the files')]),
    'list': Verb('print the names of all packages', _list),
    'prefix': Verb('print where a package is installed', _prefix, [
        _package, flag('--share', about='print its share folder')]),
    'xml': Verb('print the manifest of a package', _xml, [
        _package, argument('-t', '--tag', help='print only the texts of this tag')]),
}
