# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""Where files are found."""

from pathlib import Path
import sys

import pytest

from armsim_ros import resources
from armsim_ros.errors import ResourceError


@pytest.fixture
def install(tmp_path):
    """Return a function that installs a package with one file under a prefix."""
    def make(prefix, package, *, marker=True):
        share = tmp_path / prefix / 'share' / package
        share.mkdir(parents=True)
        (share / 'a.stl').write_text(prefix)
        if marker:
            index = tmp_path / prefix / 'share/ament_index/resource_index/packages'
            index.mkdir(parents=True, exist_ok=True)
            (index / package).touch()
        return tmp_path / prefix

    return make


@pytest.fixture
def installed_only(monkeypatch):
    """Let the code believe that it does not run from its source tree."""
    monkeypatch.setattr(resources, '_SOURCE_TREE', Path('/nowhere'))


def test_the_first_prefix_of_the_ament_index_wins(install, monkeypatch):
    """An overlay hides what it overlays."""
    prefixes = [install('overlay', 'parts'), install('underlay', 'parts')]
    monkeypatch.setenv('AMENT_PREFIX_PATH', ':'.join(map(str, prefixes)))
    assert resources.resolve_uri('package://parts/a.stl').read_text() == 'overlay'


def test_a_folder_without_marker_is_no_package_of_the_index(install, monkeypatch):
    """The ament index decides, not the folder's name."""
    prefixes = [install('stray', 'parts', marker=False), install('real', 'parts')]
    monkeypatch.setenv('AMENT_PREFIX_PATH', ':'.join(map(str, prefixes)))
    assert resources.share_folder('parts') == prefixes[1] / 'share/parts'


def test_what_pip_installed_is_found_without_the_index(install, monkeypatch):
    """sys.prefix/share serves where AMENT_PREFIX_PATH is not set."""
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    monkeypatch.setattr(sys, 'prefix', str(install('venv', 'parts')))
    assert resources.resolve_uri('package://parts/a.stl').read_text() == 'venv'


def test_a_folder_that_the_user_gives_goes_first(install, monkeypatch, tmp_path):
    """Both the folder that contains the package and the package's own folder serve."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(install('installed', 'parts')))
    own = tmp_path / 'workspace' / 'parts'
    own.mkdir(parents=True)
    assert resources.share_folder('parts', [tmp_path / 'workspace']) == own
    assert resources.share_folder('parts', [own]) == own


@pytest.mark.parametrize('text', ['$(find parts)/a.stl', '$(find-pkg-share parts)/a.stl',
                                  'package://parts/a.stl'])
def test_every_spelling_of_a_package_is_resolved(text, install, monkeypatch):
    """ROS 1, ROS 2 and URDF name a package's file differently and mean the same."""
    prefix = install('installed', 'parts')
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(prefix))
    assert resources.resolve_uri(text) == prefix / 'share/parts/a.stl'


def test_a_relative_path_starts_from_the_base(tmp_path):
    """A file named in a file lies beside it."""
    (tmp_path / 'b.stl').touch()
    assert resources.resolve_uri('b.stl', base=tmp_path) == tmp_path / 'b.stl'
    assert resources.resolve_uri(f'file://{tmp_path}/b.stl') == tmp_path / 'b.stl'
    assert str(resources.resolve_uri(f'file:///{tmp_path}/b.stl')) == f'{tmp_path}/b.stl'


def test_a_missing_package_names_the_places(monkeypatch):
    """The message says where it was looked for."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    with pytest.raises(ResourceError, match='not found; searched: /given/lost'):
        resources.share_folder('lost', [Path('/given')])


def test_a_missing_file_names_the_path_and_the_text(install, monkeypatch):
    """The message shows what was written and what it stands for."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', str(install('installed', 'parts')))
    with pytest.raises(ResourceError, match=r"parts/no.stl' does not exist.*package://parts/no"):
        resources.resolve_uri('package://parts/no.stl')


def test_the_package_finds_its_own_files_beside_its_code():
    """From the source tree the tree's files go with the tree's code."""
    assert resources.share_folder('armsim_ros') == Path(__file__).parent.parent


def test_an_installed_package_finds_its_own_files_under_the_prefix(
        install, installed_only, monkeypatch):
    """After pip install there is no source tree to look at."""
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    prefix = install('venv', 'armsim_ros')
    (prefix / 'share/armsim_ros/config/gantry').mkdir(parents=True)
    monkeypatch.setattr(sys, 'prefix', str(prefix))
    assert resources.robot_names() == ['gantry']
    assert resources.find_robot('gantry') == prefix / 'share/armsim_ros/config/gantry'


def test_a_robot_may_be_any_folder(tmp_path, monkeypatch):
    """A path is as good as a name."""
    (tmp_path / 'mine').mkdir()
    assert resources.find_robot(str(tmp_path / 'mine')) == tmp_path / 'mine'
    monkeypatch.chdir(tmp_path)
    assert resources.find_robot('mine') == tmp_path / 'mine'


def test_an_unknown_robot_is_answered_with_those_there_are():
    """A slip of the finger is named, and so are all robots."""
    name = resources.robot_names()[0]
    with pytest.raises(ResourceError) as caught:
        resources.find_robot(name[:-1])
    assert f"did you mean '{name}'?" in str(caught.value)


def test_a_world_is_found_with_and_without_its_suffix(install, installed_only, monkeypatch):
    """A world is named as its file, the suffix may be left out."""
    monkeypatch.delenv('AMENT_PREFIX_PATH', raising=False)
    prefix = install('venv', 'armsim_ros')
    worlds = prefix / 'share/armsim_ros/worlds'
    worlds.mkdir()
    (worlds / 'table.yaml').touch()
    monkeypatch.setattr(sys, 'prefix', str(prefix))
    assert resources.find_world('table') == resources.find_world('table.yaml') \
        == worlds / 'table.yaml'
    with pytest.raises(ResourceError, match=r'\(included: table; no such path\)'):
        resources.find_world('tabel')


def test_a_file_of_a_package_names_those_beside_it(tmp_path):
    """By a relative path; not a file of a folder that only has the name of a package."""
    known, stray = tmp_path / 'known' / 'parts', tmp_path / 'stray' / 'parts'
    for folder in (known, stray):
        folder.mkdir(parents=True)
        (folder / 'package.xml').write_text('<package><name>parts</name></package>')
        (folder / 'a.stl').touch()
    within = [tmp_path / 'robot']
    assert resources.resolve_uri('a.stl', [known], base=known, within=within) == known / 'a.stl'
    with pytest.raises(ResourceError, match="outside of the robot's folders"):
        resources.resolve_uri('a.stl', [known], base=stray, within=within)
