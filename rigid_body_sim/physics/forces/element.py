# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What a force element is: a record that a scene can write, a table of numbers, a kernel that answers
"what wrench now?".

A force element never integrates. Its record is a frozen dataclass; the fields are the scene keys,
described by `key`.
Elements of one type are stacked in one table, one row each, so that a kernel serves them all in
one loop and a scene without that type has neither table nor kernel. What stands where in a row is
declared at the head of the file, as a `Record` of named columns.

A wrench that depends on time itself belongs to a `TimedElement`: it says when it acts, and the
ticks are cut there, so that no integrator ever steps across its beginning or its end
(`forces.schedule`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.errors import InvalidModel
from rigid_body_sim.physics.model.place import WORLD, Place
from rigid_body_sim.physics.model.scene import Body, Vector


def key(
    kind: str,
    *,
    unit: str = '',
    default: Any = MISSING,
    minimum: float | None = None,
    choices: tuple[str, ...] = (),
) -> Any:
    """
    Describe one scene key of a force element.

        kind    : 'body', 'bodies', 'body_or_world', 'point', 'vector', 'number', 'choice' or
                  'table'
        minimum : least number allowed
        default : value where the key is absent; without one the key is required
    """
    metadata: dict[str, Any] = {'kind': kind, 'unit': unit}
    if minimum is not None:
        metadata['minimum'] = minimum
    if choices:
        metadata['choices'] = choices
    return field(default=default, metadata=metadata)


class Places(Protocol):
    """Where the bodies of a scene are kept: see `state.layout`."""

    def place(self, body: str, point: Vector | None) -> Place:
        """
        Find a point in shape coordinates of a body (None: its centre of mass), or in world
        coordinates for 'world'.
        """
        ...

    def principal_axes(self, body: str, vector: Vector) -> Vector:
        """Turn a vector from the axes of a body into its principal axes."""
        ...

    def mass(self, body: str) -> tuple[float, float, float]:
        """
        Give the mass of a body at the start [kg], its rate [kg/s] and how long that lasts [s];
        zero and zero if steady.
        """
        ...


def pushed(places: Places, body: str, point: Vector | None = None) -> Place:
    """
    Find a point of a body on which a force is to act; InvalidModel for a body that cannot move.
    """
    place = places.place(body, point)
    if place.index < 0:
        raise InvalidModel(
            f'{body!r} is fixed and cannot be pushed; choose a body without `fixed: true`'
        )
    return place


def ends_meet(of: Any, state: BodyState) -> str | None:
    """Say that the ends of a spring or bumper are at one point [m]; None: they are not."""
    point = state.point(of.a, of.a_point)
    if (point != state.point(of.b, of.b_point)).any():
        return None
    return (
        f'the ends of the {of.TYPE} between {of.a!r} and {of.b!r} are both at '
        f'({", ".join(f"{x:g}" for x in point)}) m, where it has no direction and does not push; '
        'put one a little aside'
    )


def need_two_ends(what: str, a: str, b: str) -> None:
    """Refuse an element between two points of one body, or of the world: it moves nothing."""
    if isinstance(a, str) and isinstance(b, str) and a == b:
        raise InvalidModel(
            f'both ends of this {what} are on {a!r}, and between two points that keep their '
            'distance it moves nothing; name another body',
            at=('b',),
        )


@dataclass(frozen=True, eq=False)
class BodyState:
    """
    Position, orientation and velocities of every body of a scene by name, for potential energies.

    bodies : name -> (body, position (3,) [m], matrix (3, 3) body to world)
    masses : name -> mass now [kg] of the bodies whose mass changes
    """

    bodies: Mapping[str, tuple[Body, NDArray[np.float64], NDArray[np.float64]]]
    masses: Mapping[str, float] = field(default_factory=dict)

    def mass(self, body: Body) -> float:
        """Mass of a body now [kg]."""
        return self.masses.get(body.name, body.mass)

    def point(self, body: str, point: Vector | None) -> NDArray[np.float64]:
        """
        Give a point of a body (shape coordinates; None: its centre of mass) or of the world in
        world axes [m].
        """
        if body == WORLD:
            return np.asarray(point if point is not None else (0.0, 0.0, 0.0))
        record, position, matrix = self.bodies[body]
        if point is None:
            return position
        return position + matrix @ (np.asarray(point, dtype=float) - record.center_of_mass)


@dataclass(frozen=True)
class Tie:
    """
    How strongly an element holds or brakes a body, for the estimate of the fastest motion of a
    scene (`diagnostics.step_limits`).

    a, b              : (body, point) as in the scene; b is 'world' where nothing moves with it
    stiffness         : [N/m]          largest change of the force with the distance of the ends
    damping           : [N s/m]        the same with their relative velocity, at rest
    quadratic         : [N s^2/m^2]    what |v| adds to that
    angular           : [N m s]        resistance to the rotation of a
    angular_quadratic : [N m s^2]      what |omega| adds to that
    linear            : whether the force is linear in the positions of the ends
    """

    a: tuple[str, Vector | None]
    b: tuple[str, Vector | None] = (WORLD, None)
    stiffness: float = 0.0
    damping: float = 0.0
    quadratic: float = 0.0
    angular: float = 0.0
    angular_quadratic: float = 0.0
    linear: bool = False


class ForceElement(Protocol):
    """
    One force of a scene.

    TYPE       : scene type
    COLUMNS    : width of a row of its table; None where rows differ: then each begins with its own
                 width
    accumulate : kernel (elements, start, count, time, translation, rotation) that adds the
                 wrenches of `count` rows from `start` on
    power      : optional kernel (elements, start, count, time, translation, rotation, out) that
                 adds what they give to or take from the bodies now, beside their potential: see
                 `forces.power`; without it, an element that does not conserve energy is taken for
                 a drive that stores none
    linearise  : optional kernel (elements, start, count, time, translation, rotation, table,
                 definite) that adds the derivatives of those wrenches: see `forces.derivatives`;
                 without it they are found by differences
    brings_energy : optional method () -> bool: whether its power counts as that of a drive, which
                 may bring energy in; without it the element stores energy or takes it
    turns      : optional method (body) -> bool: whether it exerts a torque about the centre of
                 mass of one of its bodies; without it, it counts as if it did
    no_energy  : optional method (BodyState) -> str | None: in words, who is where its energy is no
                 number; a scene that begins there is refused
    no_direction : optional method (BodyState) -> str | None: in words, where its force has no
                 direction and is therefore left out; a scene that begins there is warned of
    tie        : optional method () -> Tie: how strongly it holds or brakes; without it the element
                 counts for nothing when a run is warned of a step that is too long
    """

    TYPE: str
    COLUMNS: int | None
    accumulate: Callable[..., None]

    def row(self, places: Places) -> tuple[float, ...]:
        """Give the row of the table."""
        ...

    def bodies(self) -> tuple[str, ...]:
        """
        Name the bodies it acts on; a pair feels opposite forces, a single one is pushed from
        outside.
        """
        ...

    def depends_on_velocity(self) -> bool:
        """Tell whether the wrench changes with velocity."""
        ...

    def conserves_energy(self) -> bool:
        """Tell whether kinetic energy plus `potential_energy` stays the same under this force."""
        ...

    def potential_energy(self, state: BodyState) -> float:
        """Give the energy stored [J]."""
        ...


class TimedElement(ForceElement, Protocol):
    """
    A force that depends on time itself, and may act for a while only.

    SWITCH : column of its row that holds 1 while it acts and 0 otherwise: set between steps, read
             by the kernel
    """

    SWITCH: int

    def acts(self) -> tuple[float, float]:
        """
        Give the instants [s] since the start of the scene at which it jumps from zero and to zero,
        or infinities.
        """
        ...

    def kinks(self) -> tuple[float, ...]:
        """
        Give the instants [s] at which a derivative of it jumps; an element without any needs no
        such method.
        """
        ...
