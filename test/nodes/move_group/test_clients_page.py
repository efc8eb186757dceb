# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The page on the clients."""

from pathlib import Path
import re

PAGE = Path(__file__).parents[3] / 'docs' / 'clients.md'


def test_the_example_runs(stack, monkeypatch, capsys):
    """The program of the page plans, moves, lists controllers and sends a trajectory."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(stack.client.context.get_domain_id()))
    program, = re.findall(r'```python\n(.*?)```', PAGE.read_text(encoding='utf-8'), re.DOTALL)
    exec(compile(program, 'clients.md', 'exec'), {})
    printed = capsys.readouterr().out
    assert "'arm_joint_controller': 'active'" in printed
    assert 'error_code=0' in printed
