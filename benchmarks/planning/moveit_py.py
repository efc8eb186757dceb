# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""A script of moveit_py beside a simulated Panda: its start, plans, states and memory."""

from __future__ import annotations

import json
from pathlib import Path
from statistics import median
import subprocess
import sys
from tempfile import TemporaryDirectory
import time
from typing import Any

import yaml

from armsim_ros.config.robot_folder import find_files
from armsim_ros.model.description.xacro_text import read_description
from armsim_ros.testing.program import ros_environment
from benchmarks.options import Options
from benchmarks.stack import running_stack

SCRIPT = Path(__file__).with_name('moveit_py_script.py')
ROOT = Path(__file__).resolve().parents[2]
#: Key of the script's output -> what it is, and its unit.
ROWS = {
    'first_plan': 'start of the script to the first plan [s]',
    'plan': 'plan(), median of 20 [ms]',
    'move_group': '/plan_kinematic_path of move_group, the same request [ms]',
    'same': 'trajectories that are equal to the last bit, of 20',
    'colliding': 'is_state_colliding, processor time [us]',
    'ik': 'set_from_ik near its seed, processor time [us]',
    'transform': 'get_global_link_transform, processor time [us]',
    'memory': 'resident memory after a plan and its execution [MiB]',
}


def main(options: Options) -> None:
    """Print medians over several starts of the script."""
    found: list[dict[str, float]] = []
    with TemporaryDirectory() as folder, running_stack(
            'robot:=panda', 'overrides:={ompl.planning_seed: 7}') as stack:
        file = Path(folder, 'parameters.json')
        file.write_text(json.dumps(parameters()), encoding='utf-8')
        environment = ros_environment(stack.domain)
        environment['PYTHONPATH'] = f'{ROOT}:{ROOT / "distributions/moveit"}'
        for _ in range(options.runs):
            began = time.time()
            done = subprocess.run(
                [sys.executable, str(SCRIPT), str(file), str(began)], env=environment, text=True,
                stdout=subprocess.PIPE, check=True)
            found.append(json.loads(done.stdout.splitlines()[-1]))
    for key, text in ROWS.items():
        values = [each[key] for each in found]
        print(f'{text:>62} {median(values):9.3g}   {min(values):9.3g} .. {max(values):.3g}')


def parameters() -> dict[str, Any]:
    """Return the parameters that a launch file would give the script."""
    files = find_files('panda')
    assert files.urdf_file is not None
    assert files.srdf_file is not None
    return {
        'robot_description': read_description(files.urdf_file),
        'robot_description_semantic': files.srdf_file.read_text(encoding='utf-8'),
        'robot_description_kinematics': _read(files.folder / 'kinematics.yaml'),
        'robot_description_planning': _read(files.folder / 'joint_limits.yaml'),
        **_read(files.folder / 'moveit_controllers.yaml'),
        'planning_pipelines': {'pipeline_names': ['ompl']},
        'ompl': {'planning_plugins': ['ompl_interface/OMPLPlanner'], 'planning_seed': 7},
        'plan_request_params': {'planning_pipeline': 'ompl', 'planning_attempts': 1},
        'planning_scene_monitor_options': {'wait_for_initial_state_timeout': 10.0},
    }


def _read(path: Path) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load(path.read_text(encoding='utf-8'))
    return content
