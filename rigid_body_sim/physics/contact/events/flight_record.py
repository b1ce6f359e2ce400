# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A body in flight between two impacts, as it is at an instant of its own; what is seen of a collider
at another instant; and an event: a pair of colliders that may meet in the tick.
"""

from rigid_body_sim.physics.arrays import Record
from rigid_body_sim.physics.state.blocks import ROTATION

flight = Record()
TIME = flight.number('s', 'instant of the state, since the start of the tick; NOT_LOADED')
POSITION = flight.vector('m', 'of the centre of mass, world')
POSITION_RESIDUAL = flight.vector('m', 'what rounding lost of it')
MOMENTUM = flight.vector('kg m/s', 'world axes')
MOMENTUM_RESIDUAL = flight.vector('kg m/s', 'what rounding lost of it')
ORIENTATION = flight.quaternion('-', 'principal axes to world')
ANGULAR_MOMENTUM = flight.vector('kg m^2/s', 'about the centre of mass, world axes')
FORCE = flight.vector('N', 'held over the tick')
TORQUE = flight.vector('N m', 'held over the tick, world axes')
INVERSE_MASS = flight.number('1/kg', '')
INVERSE_MOMENTS = flight.vector('1/(kg m^2)', 'principal')
MASS_SCALE = flight.number('-', 'm0/m now, of a mass that changes: see `solver.variable_mass`')
STRUCK = flight.number('-', '1: an impact has changed its motion in this tick')
REACH = flight.number('m', 'bound of its way in this tick, from where it began')
BEGUN_AT = flight.vector('m', 'where its centre of mass was at the start of the tick')
SIZE = flight.padding(48)  # six cache lines

NOT_LOADED = -1.0

view = Record()
CENTER = view.vector('m', 'centre of mass of the body')
VELOCITY = view.vector('m/s', '')
ACCELERATION = view.vector('m/s^2', '')
SPIN = view.vector('rad/s', 'of the surface: what leaves the shape where it is does not count')
BEND = view.number('m/s^2', 'bound of what turning adds to the acceleration of points')
SPIN_BOUND = view.number('rad/s', 'bound of the spin')
VIEW = view.size

event = Record()
COLLIDER_A = event.number('-', 'number of collider A; type of A <= type of B')
COLLIDER_B = event.number('-', 'number of collider B')
INSTANT = event.number('s', 'at which the two meet, since the start of the tick; infinite: never')
APPROACH = event.number('m/s', 'speed at which they approach each other then')
STRUCK_SO_FAR = event.number('-', 'impacts of the pair in this tick')
SLOW = event.number('m/s', 'a slower approach is no impact: the solver takes the pair')
NORMAL = event.vector('-', 'axis along which they meet, from A to B')
GAP = event.number('m', 'of the two where it was looked for')
MANIFOLD = event.number('-', 'place of its manifold; NONE')
HELD = event.number('-', 'how many of the two the solver moved when they were asked; KEPT')
PART = event.number('-', 'of ground, which part is met: see `on_ground`; NO_PART')
LOADED = event.number(
    '-', 'pair id of its manifold, which carries load elsewhere: see `free_points`; NONE'
)
NO_GAP = event.number('m', 'a smaller gap of the two is round-off of their places')
EVENT = event.padding(16)

piece = Record()
PIECE_OF_A = piece.number('-', 'vertex, end or rim of A: see `best_axis`')
PIECE_OF_B = piece.number('-', 'that of B')
AHEAD = piece.number('m', 'how far the two are apart along the axis')
SLOPE_U = piece.number('m', 'how that changes as the axis turns to one vector across it')
SLOPE_V = piece.number('m', 'and to another one')
PIECE = piece.size
MOST_PIECES = 8

NEVER = 1e300  # [s]
NONE = -1.0
KEPT = 3.0  # the pair is left to the solver
NO_PART = 0.0

# behind the two views: where points of an impact are listed, and the corners of A and of B that
# they are found from
MOST_POINTS = 8
TOUCHING = 2 * VIEW
CORNERS_A = TOUCHING + 3 * MOST_POINTS
CORNERS_B = CORNERS_A + 3 * MOST_POINTS
# and then the axis of the last evaluation (none: 0), the facets of ground that are asked, and the
# pieces that an axis is found from
LAST_AXIS = CORNERS_B + 3 * MOST_POINTS
FIRST_PART = LAST_AXIS + 3  # an event: of the part of ground that is met first
FACETS = FIRST_PART + EVENT
FACET, LEFT_FROM = 0, 1  # of each: its number; from which instant on its triangles are asked [s]
FACET_SIZE = 2
MOST_FACETS = 48
PIECES_KNOWN = FACETS + FACET_SIZE * MOST_FACETS  # how many there are
PIECES = PIECES_KNOWN + 1
# and the last pair of the tick whose instant was not found: 1: there is one; colliders A and B
UNDECIDED = PIECES + PIECE * MOST_PIECES
VIEWS = UNDECIDED + 3
BEHIND_BLOCKS = VIEWS + 2 * ROTATION  # and behind the blocks in which A and B are turned
