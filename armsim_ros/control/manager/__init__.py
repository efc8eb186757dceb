# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""The controller manager: loading, switching, and the order of controllers."""
