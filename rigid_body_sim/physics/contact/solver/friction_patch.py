# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What the solver knows of the friction of a manifold of several points, in wide lanes: rows of eight
numbers behind those of its points, see `constraint`.

The friction of such a manifold is one force at its centre and one twist about the normal there.
Its centre is the mean of its points as they pressed at the start of the tick, or of the nearest
ones where nothing has pressed yet, and follows them;
what presses within the tick may have another one, see `patch_friction`.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.contact.collision.geometry.manifold import MOST
from rigid_body_sim.physics.contact.solver.constraint import LANES

patch = Record(stride=LANES)
ARM_A = patch.vector('m', 'of the centre, from the centre of mass of A, world axes')
ARM_B = patch.vector('m', 'of the centre, from the centre of mass of B, world axes')
WEIGHTS = patch.numbers(MOST, '-', 'of the points in the centre; none: 0')
UNIFORM = patch.number('-', 'k_face: second moment of the whole face over that of its points')
FIRST_OTHER = patch.number(
    '-', 'where the lane of the next of a surface is, or a name of those there'
)
NEXT_OTHER = patch.number(
    '-', 'the same, of one that has no friction of its own: `surface_friction`'
)
MOVER = patch.number('-', '1: the body whose faces they are is A, -1: B')
FORCE_RATE = patch.number('1/kg', 'largest velocity per tangential impulse at the centre')
TWIST_RATE = patch.number('1/(kg m^2)', 'twisting velocity per angular impulse')
COUPLING = patch.number('1/(kg m)', 'largest twisting velocity per tangential impulse')
MEASURED = patch.number('N s', 'what pressed when the next six were found')
MIDDLE_1 = patch.number('m', 'of what presses, from the centre, first tangent: c')
MIDDLE_2 = patch.number('m', 'the same, second tangent')
RADIUS_SQUARED = patch.number('m^2', 'tau_0^2: torque over friction, squared')
INVERSE_SQUARED = patch.number('1/m^2', 'one over it; 0 for a point')
LENGTH_SQUARED = patch.number('m^2', 'l^2: step of the twist over that of the force')
STEP = patch.number('kg', 'g: impulse per velocity')
IMPULSE_1 = patch.number('N s', 'accumulated in this substep, first tangent')
IMPULSE_2 = patch.number('N s', 'the same, second tangent')
TWIST = patch.number('N m s', 'the same, about the normal at the centre')
WARM_1 = patch.number('N s', 'half the warm-start impulse of this substep, first tangent')
WARM_2 = patch.number('N s', 'the same, second tangent')
WARM_TWIST = patch.number('N m s', 'the same, about the normal')
WARM_NORMAL = patch.number('N s', 'half the warm-start impulses of all points along the normal')
TOTAL_1 = patch.number('N s', 'over the tick, without this substep, first tangent')
TOTAL_2 = patch.number('N s', 'the same, second tangent')
TOTAL_TWIST = patch.number('N m s', 'the same, about the normal')
RESTITUTION_1 = patch.number('N s', 'with the impulse of restitution, first tangent')
RESTITUTION_2 = patch.number('N s', 'the same, second tangent')
RESTITUTION_TWIST = patch.number('N m s', 'the same, about the normal')
# while an island goes on that the usual passes have left unsettled: see `islands.unsettled`
BEGUN_BEFORE_1 = patch.number('N s', 'from which the pass before began, first tangent')
BEGUN_BEFORE_2 = patch.number('N s', 'the same, second tangent')
BEGUN_BEFORE_TWIST = patch.number('N m s', 'the same, about the normal')
BEGUN_1 = patch.number('N s', 'from which this pass has begun, first tangent')
BEGUN_2 = patch.number('N s', 'the same, second tangent')
BEGUN_TWIST = patch.number('N m s', 'the same, about the normal')
SIZE = patch.size
