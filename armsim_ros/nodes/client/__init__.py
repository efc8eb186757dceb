# Copyright 2026 armsim_ros authors
# SPDX-License-Identifier: Apache-2.0
"""What programs need that talk to a running robot through its public interfaces alone."""
