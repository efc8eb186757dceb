# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The classes that launch files import, under the names of ``armsim_ros.launch.names``."""
