# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""SDF texts of small models."""


def model(inside, name='m', more=''):
    """Return an SDF text with one model."""
    return f'<sdf version="1.9"><model name="{name}">{more}{inside}</model></sdf>'


def link(shape, name='l', pose='0 0 0 0 0 0', more=''):
    """Return an SDF link with one collision."""
    return (f'<link name="{name}"><pose>{pose}</pose>{more}<collision name="c"><geometry>{shape}'
            '</geometry></collision></link>')


BOX = '<box><size>0.1 0.2 0.3</size></box>'
BALL = '<sphere><radius>0.05</radius></sphere>'
