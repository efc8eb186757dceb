"""Builds armsim_ros for colcon (lib/armsim_ros programs) and for pip (the armsim command)."""

from setuptools import setup

setup()
