"""check_config of a cell: its own files, those of its robots, each mistake once."""

import pytest

from armsim_ros.tools.check_config.main import main


@pytest.fixture
def told(tmp_path, capsys):
    """Return a function from files of a cell to (status, what is printed)."""
    def check(*options, **files):
        for name, text in files.items():
            (tmp_path / f'{name}.yaml').write_text(text)
        status = main([str(tmp_path), *options])
        return status, capsys.readouterr().out.replace(f'{tmp_path}/', '')
    return check


def test_files_and_coverage(told):
    """The files of the cell, then of each robot once; groups with their controllers."""
    status, text = told(robots='robots: {a: {robot: elfin}, b: {robot: elfin, xyz: [2, 0, 0]}}')
    assert status == 0
    assert 'robots  robots.yaml' in text
    assert text.count("robot 'elfin'") == 1
    assert 'b_elfin_arm (b_elfin_joint1' in text
    assert ': b/elfin_arm_controller' in text
    assert text.endswith('result: all is well\n')


def test_mistakes_of_robots_yaml_are_told_once(told):
    """With line and hint, and no word about keys of other files."""
    status, text = told(robots='robots:\n  a: {robt: elfin}\n')
    assert status == 2
    assert "robots.yaml:2:7: cell: key 'robots.a.robt' is not known" in text
    assert "did you mean 'robot'?" in text
    assert 'result: 2 errors, 0 warnings' in text


def test_keys_of_all_files_are_listed(told):
    """Those of the cell and of its robots."""
    _, text = told('--keys', robots='robots: {a: {robot: elfin}}', simulation='timestep: 0.001')
    assert 'simulation.yaml:1:1: timestep: 0.001' in text
    assert 'elfin_arm_controller.constraints.goal_time: 0.6' in text


def test_the_file_alone(told, tmp_path, capsys):
    """robots.yaml by itself is checked as what it is."""
    (tmp_path / 'robots.yaml').write_text('robots: {a: {robot: elfin, xyz: here}}')
    assert main([str(tmp_path / 'robots.yaml')]) == 2
    assert "'robots.a.xyz' is the text 'here'" in capsys.readouterr().out


def test_overlapping_robots_are_told(told):
    """The physics finds them at the start."""
    status, text = told(robots='robots: {a: {robot: bot}, b: {robot: bot, xyz: [0.05, 0, 0]}}')
    assert status == 1
    assert 'overlap by' in text
