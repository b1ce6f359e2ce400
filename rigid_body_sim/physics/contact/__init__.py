# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Contact of rigid bodies by time stepping; imported only by scenes that ask for it.

`world` what a scene needs; `ticks` let time pass; `step` what happens in a tick, by its stages
`detection`, `assembly`, `substeps`, `tick_end`; `world_memory` what the next one starts from;
`world_readout` what can be read of it.
`collision` tells who meets where; `solver` makes constraints of it and finds impulses; `energy`
bounds what they return; `islands` lets bodies sleep.
"""
