"""Folders with a user's files, one mistake at a time."""

from pathlib import Path
import shutil

import pytest

from armsim_ros.config.loading import load_robot_settings
from armsim_ros.errors import ConfigError
from armsim_ros.resources import find_robot, PACKAGE, share_folder


class RobotFiles:
    """A copy of the sunday robot's files in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder / 'sunday'
        shutil.copytree(find_robot('sunday'), self.folder)
        shutil.copy(share_folder(PACKAGE) / 'urdf' / 'sunday.urdf.xacro', self.folder)

    def write(self, name, text):
        """Write a file; bytes as they are."""
        data = text if isinstance(text, bytes) else text.encode()
        (self.folder / name).write_bytes(data)
        return self

    def replace(self, name, old, new):
        """Change a text that stands in a file once."""
        text = (self.folder / name).read_text(encoding='utf-8')
        assert text.count(old) == 1, f'{old!r} is there {text.count(old)} times'
        return self.write(name, text.replace(old, new))

    def remove(self, *names):
        """Remove files."""
        for name in names:
            (self.folder / name).unlink()
        return self

    def load(self, **arguments):
        """Return the settings."""
        return load_robot_settings(str(self.folder), **arguments)

    def complaints(self, **arguments):
        """Return the messages of the mistakes, with the folder's path left out."""
        with pytest.raises(ConfigError) as caught:
            self.load(strict=True, **arguments)
        return [str(one).replace(f'{self.folder}/', '') for one in caught.value.problems]

    def remarks(self, **arguments):
        """Return the messages that are no mistakes."""
        return [str(one).replace(f'{self.folder}/', '') for one in self.load(**arguments).remarks]


@pytest.fixture
def files(tmp_path):
    """Return a folder with the sunday robot's files."""
    return RobotFiles(tmp_path)
