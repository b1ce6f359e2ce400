# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
Tests of controllers: a pytest fixture that starts the real node, and a client that talks to it.

    def test_damper_stops_the_satellite(simulation):
        sim = simulation('satellite', lockstep=['satellite/torque'])

Every pytest of an environment loads `plugin`, so that nothing is imported here before it is used.
"""

TYPE_CHECKING = False  # to those who run it
if TYPE_CHECKING:
    from rigid_body_sim.testing.failures import NodeFailure
    from rigid_body_sim.testing.live_simulation import LiveSimulation
    from rigid_body_sim.testing.wrench import Wrench

_ROOMS = {
    'LiveSimulation': 'live_simulation',
    'NodeFailure': 'failures',
    'Wrench': 'wrench',
}
__all__ = ['LiveSimulation', 'NodeFailure', 'Wrench']


def __getattr__(name: str):
    """Import what is asked for."""
    if name not in _ROOMS:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    from importlib import import_module

    return getattr(import_module(f'{__name__}.{_ROOMS[name]}'), name)
