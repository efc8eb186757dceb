# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The files in share/ that tools read, as ``ros2 interface`` does."""

from importlib import metadata
import json
import os
from pathlib import Path
import sys
import xml.etree.ElementTree as ElementTree

from ament_index_python import get_package_share_directory, get_resource
import pytest


@pytest.fixture(autouse=True)
def ament_index(monkeypatch):
    """Search the environment's own prefix too."""
    prefixes = [sys.prefix, *filter(None, [os.environ.get('AMENT_PREFIX_PATH')])]
    monkeypatch.setenv('AMENT_PREFIX_PATH', os.pathsep.join(prefixes))


def files_of(definitions, package):
    """Return the definition files of a package, relative to its folder."""
    return [
        Path(kind, f'{name}.{kind}')
        for owner, kind, name in (name.split('/') for name in definitions) if owner == package]


def test_index(definitions, package):
    """The ament index lists the package and its interfaces."""
    get_resource('packages', package)
    listed, _ = get_resource('rosidl_interfaces', package)
    expected = {
        form.as_posix() for path in files_of(definitions, package)
        for form in (path, path.with_suffix('.idl'))}
    assert set(listed.split()) >= expected


def test_manifest(package):
    """package.xml names the package as one of interfaces."""
    manifest = ElementTree.parse(Path(get_package_share_directory(package), 'package.xml'))
    assert manifest.findtext('name') == package
    assert manifest.findtext('member_of_group') == 'rosidl_interface_packages'


def test_forms(definitions, type_hashes, package):
    """Every interface has its definition, its IDL, and its description with the hash."""
    share = Path(get_package_share_directory(package))
    for path in files_of(definitions, package):
        assert (share / path).is_file()
        assert f'module {package}' in (share / path.with_suffix('.idl')).read_text('utf-8')
        described = json.loads((share / path.with_suffix('.json')).read_text('utf-8'))
        name = f'{package}/{path.parent}/{path.stem}'
        assert described['type_hashes'][0] == {
            'type_name': name, 'hash_string': type_hashes[name]}


def test_built_from_this_tree(definitions, package, source):
    """What our distribution installed are the definitions of this source tree."""
    try:
        installed = {str(path) for path in metadata.files('armsim-ros-interfaces')}
    except metadata.PackageNotFoundError:
        pytest.skip('the packages come from a ROS installation')
    if not any(path.startswith(f'{package}/') for path in installed):
        pytest.skip(f'{package} comes from a ROS installation')
    share = Path(get_package_share_directory(package))
    for path in files_of(definitions, package):
        assert (share / path).read_bytes() == (source / package / path).read_bytes()


def test_no_other_definitions(definitions, package, source):
    """The source tree has exactly the interfaces of the releases."""
    found = {
        path.relative_to(source / package) for kind in ('msg', 'srv', 'action')
        for path in (source / package / kind).glob('*')}
    assert found == set(files_of(definitions, package))


def test_every_definition_is_described(package, source):
    """Each definition file begins with a sentence about it, in ASCII as the adapter needs."""
    for kind in ('msg', 'srv', 'action'):
        for path in (source / package / kind).glob('*'):
            first = path.read_bytes().decode('ascii').splitlines()[0]
            assert first.startswith('# '), path
            assert len(first) > 15, path
