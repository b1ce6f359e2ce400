# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What can be said of a scene before it runs: its bodies, what it needs, what each integrator may do.

Of a body: mass, centre of mass, inertia tensor I about the centre of mass in body axes, and its
principal axes, I = V diag(moments) V^T with the axes as the columns of V. A fixed body has none of
them but what its scene states, a point mass no inertia.

Of an integrator: whether it takes the scene, and at a tick the products of its step h with the
rates of the scene at the start (`physics.diagnostics.step_limits`), beside the largest that it
stays within (that of rotation is longer where the moments of a body are near one another, with
some methods shorter where they are far apart; `beyond` counts both).
`recommended` are those of order four and up that take the scene, stay within all limits and are
no reference methods; where none of them does, those of lower order that do. The order is that of
free bodies where nothing pushes or holds them but uniform gravity and commands. Rates change while
a scene runs, and no rate tells an error: `integrator: auto` measures one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from rigid_body_sim.errors import UserError
from rigid_body_sim.physics.diagnostics.step_limits import (
    KINDS,
    StabilityWatch,
    substeps_of_contact,
)
from rigid_body_sim.physics.integration.integrator import Integrator
from rigid_body_sim.physics.integration.integrators import INTEGRATORS
from rigid_body_sim.physics.model.body_axis import moment_of_body
from rigid_body_sim.physics.model.inertia_over_time import changing
from rigid_body_sim.physics.model.principal_axes import principal_axes
from rigid_body_sim.physics.model.scene import Body, Scene
from rigid_body_sim.physics.model.shapes import ConvexHull, Mesh, Particles, Shape
from rigid_body_sim.physics.model.variable_mass import end_of_flow, flow_of
from rigid_body_sim.physics.state.layout import Layout
from rigid_body_sim.physics.state.snapshot import State, StateReader

Rows = list[list[float]]

TAKE_MOST = ('dmv6', 'lie_rk4')  # integrators; the first refuses what changes its inertia alone
GOOD_ORDER = 4  # [-] of the global error: from here on a method is recommended
OF_A_RIGID_BODY, OF_A_PIVOT, OF_A_POINT = 6, 3, 3  # degrees of freedom


@dataclass(frozen=True)
class BodyFacts:
    """
    What is known of a body.

    kind              : 'rigid', 'point mass' or 'fixed'
    mass              : [kg]      None for a fixed body without one
    center_of_mass    : (3,) [m]  body axes
    inertia           : (3, 3) [kg m^2]  about the centre of mass, body axes; None: fixed, without
    principal_moments : (3,) [kg m^2]
    principal_axes    : (3, 3) [-]  columns are the axes
    degrees_of_freedom : how many numbers say where it is
    points, coordinates, constraints : of the points that its shape lists, if it does: there are n
        of them, 3 n coordinates, and what rigidity takes from these
    frames : name -> position (3,) [m] from the centre of mass and orientation (4,) [-] xyzw, body
        axes, of the frames fixed to it
    """

    name: str
    kind: str
    shape: str | None
    mass: float | None
    center_of_mass: list[float]
    inertia: Rows | None
    principal_moments: list[float] | None
    principal_axes: Rows | None
    degrees_of_freedom: int
    points: int | None = None
    coordinates: int | None = None
    constraints: int | None = None
    frames: dict[str, dict[str, list[float]]] = field(default_factory=dict)


@dataclass(frozen=True)
class StepOfKind:
    """
    One limit of an integrator: a product with its step, and the largest allowed.

    kind    : 'rotation' (h |omega| [rad]), 'oscillation' (h omega [rad]) or 'relaxation' (h k)
    product : the largest of all bodies; None beyond all numbers
    limit   : None where there is none
    """

    kind: str
    product: float | None
    limit: float | None


@dataclass(frozen=True)
class IntegratorFacts:
    """
    What an integrator may do with a scene.

    order   : None where it is exact
    refused : why it does not take the scene; None if it does
    steps   : its limits
    beyond  : limits that it does not keep at this dt, a line each
    """

    name: str
    order: float | None
    keeps: str
    stability: str
    is_reference: bool
    refused: str | None
    steps: list[StepOfKind] = field(default_factory=list)
    beyond: list[str] = field(default_factory=list)
    recommended: bool = False


def bodies_of(scene: Scene) -> list[BodyFacts]:
    """Say of every body what the module lists."""
    return [_of_body(body) for body in scene.bodies]


def _of_body(body: Body) -> BodyFacts:
    inertia = body.inertia
    if inertia is None and body.is_point:
        inertia = np.zeros((3, 3))
    moments, axes = (None, None) if inertia is None else principal_axes(inertia)
    kind = 'fixed' if body.fixed else 'point mass' if body.is_point else 'rigid'
    freedom = {'fixed': 0, 'point mass': OF_A_POINT, 'rigid': OF_A_RIGID_BODY}[kind]
    if body.pivot is not None:
        freedom = OF_A_PIVOT
    points = _points(body)
    listed = points is not None and kind == 'rigid'
    return BodyFacts(
        name=body.name,
        kind=kind,
        shape=None if body.shape is None else shape_name(body.shape),
        mass=None if body.fixed and body.mass == 0.0 else body.mass,
        center_of_mass=list(body.center_of_mass),
        inertia=None if inertia is None else inertia.tolist(),
        principal_moments=None if moments is None else moments.tolist(),
        principal_axes=None if axes is None else axes.tolist(),
        degrees_of_freedom=freedom,
        points=points if listed else None,
        coordinates=3 * points if listed and points is not None else None,
        constraints=3 * points - freedom if listed and points is not None else None,
        frames={
            name: {'position': list(frame.position), 'orientation': list(frame.orientation)}
            for name, frame in body.frames.items()
        },
    )


def shape_name(shape: Shape) -> str:
    """Return what a scene calls the type of a shape: `convex_hull` of ConvexHull."""
    words = re.findall('[A-Z][a-z]*', type(shape).__name__)
    return '_'.join(words).lower()


def _points(body: Body) -> int | None:
    match body.shape:
        case Particles(positions=positions):
            return len(positions)
        case ConvexHull(vertices=vertices) | Mesh(vertices=vertices):
            return len(vertices)
        case _:
            return None


def moment_of(
    scene: Scene, name: str, *, direction: ArrayLike, point: ArrayLike | None = None
) -> dict[str, Any]:
    """
    Return the moment of inertia of a body about an axis, at the start of the scene.

    direction : (3,)      along the axis, body axes
    point     : (3,) [m]  of the axis, shape coordinates; None: the centre of mass

    Raises UserError for an unknown body; InvalidModel for one without inertia, and for no axis.
    """
    body = next((body for body in scene.bodies if body.name == name), None)
    if body is None:
        known = ', '.join(body.name for body in scene.bodies[:8])
        raise UserError(f'no body is named {name!r}; the scene has: {known}')
    moment = moment_of_body(body, direction=direction, point=point)
    at = body.center_of_mass if point is None else point
    return {
        'body': name,
        'direction': np.asarray(direction, dtype=np.float64).tolist(),
        'point': np.asarray(at, dtype=np.float64).tolist(),
        'moment': moment,
        'moment_through_center': moment_of_body(body, direction=direction),
        'radius_of_gyration': math.sqrt(moment / body.mass),
    }


def needs_of(scene: Scene) -> dict[str, Any]:
    """
    Say what a scene asks of whoever runs it.

    rotation      : bodies that turn
    contact       : its mode, 'none' where nothing touches
    coupled       : types of force elements: what pushes depends on where bodies are
    on_velocity   : those of them that depend on velocities too
    timed         : instants [s] at which something begins or ends; None: nothing depends on time
    is_free       : whether nothing acts but uniform gravity and commands
    inertia_over_time : bodies whose inertia changes
    pivots        : bodies that turn about a fixed point
    degrees_of_freedom : of all bodies; `coordinates` three for each point mass, and the twelve of
        r and R for each rigid body
    """
    moving = [body for body in scene.bodies if not body.fixed]
    rigid = [body for body in moving if not body.is_point]
    timed = [force for force in scene.forces if hasattr(force, 'acts')]
    flowing = [body for body in scene.bodies if flow_of(body) is not None]
    turning = changing(scene)
    instants = {t for force in timed for t in force.acts()} | {end_of_flow(b) for b in flowing}
    for body in turning:
        assert body.inertia_over_time is not None
        instants |= {row[0] for row in body.inertia_over_time.table}
    return {
        'moving': len(moving),
        'fixed': len(scene.bodies) - len(moving),
        'rotation': len(rigid),
        'contact': str(scene.contact.get('mode', 'none')),
        'gravity': list(scene.gravity),
        'coupled': sorted({force.TYPE for force in scene.forces}),
        'on_velocity': sorted({f.TYPE for f in scene.forces if f.depends_on_velocity()}),
        'timed': sorted(t for t in instants if math.isfinite(t))
        if timed or flowing or turning
        else None,
        'inertia_over_time': [body.name for body in turning],
        'is_free': is_free(scene),
        'pivots': [body.name for body in scene.bodies if body.pivot is not None],
        'degrees_of_freedom': sum(
            OF_A_POINT if body.is_point else OF_A_PIVOT if body.pivot else OF_A_RIGID_BODY
            for body in moving
        ),
        'coordinates_of_matrices': 12 * len(rigid) + 3 * (len(moving) - len(rigid)),
    }


def integrators_of(
    scene: Scene, *, dt: float, progress: Callable[[str], None] | None = None
) -> list[IntegratorFacts]:
    """
    Say of every integrator what it may do with a scene at a tick dt [s].

    The integrator of the scene has the options of the scene, others their defaults.
    """
    layout = Layout(scene)
    reader = StateReader(layout)
    state = reader.read(layout.translation(), layout.rotation(), 0.0)
    found = []
    for name, integrator in sorted(INTEGRATORS.items()):
        if progress is not None:
            progress(name)
        given = scene.integrator_options if name == scene.integrator else {}
        found.append(_of_integrator(scene, layout, state, integrator.configured(given), dt))
    able = [facts for facts in found if not (facts.refused or facts.beyond or facts.is_reference)]
    good = [facts for facts in able if facts.order is None or facts.order >= GOOD_ORDER] or able
    return [replace(facts, recommended=facts in good) for facts in found]


def able_integrator(scene: Scene) -> str:
    """Name an integrator that takes a scene: its own, or else one that takes most."""
    for name in (scene.integrator, *TAKE_MOST):
        if name in INTEGRATORS:
            given = scene.integrator_options if name == scene.integrator else {}
            if _refusal(scene, INTEGRATORS[name].configured(given)) is None:
                return name
    return TAKE_MOST[0]


def _of_integrator(
    scene: Scene, layout: Layout, state: State, integrator: Integrator, dt: float
) -> IntegratorFacts:
    refused = _refusal(scene, integrator)
    order = integrator.free_order if is_free(scene) else integrator.order
    facts = IntegratorFacts(
        name=integrator.name,
        order=order if math.isfinite(order) else None,
        keeps=integrator.keeps,
        stability=integrator.stability,
        is_reference=integrator.is_reference,
        refused=refused,
    )
    if refused is not None:
        return facts
    watch = StabilityWatch(scene, layout, integrator, dt)
    with np.errstate(all='ignore'):  # what overflows is beyond every limit
        rates = watch.rates(state)
    h = dt / (integrator.substeps * substeps_of_contact(scene))
    for kind in KINDS:
        limit = getattr(integrator.limits, kind)
        if kind == 'oscillation' and watch.has_bent_ties:
            limit = min(limit, integrator.limits.bent)
        product = h * float(np.max(rates[kind], initial=0.0))
        facts.steps.append(StepOfKind(kind, _finite(product), _finite(limit)))
    facts.beyond.extend(violation.text for violation in watch.check(state))
    return facts


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None


def is_free(scene: Scene) -> bool:
    """Tell whether nothing but uniform gravity and commands acts on the bodies of a scene."""
    held = any(body.pivot is not None or flow_of(body) is not None for body in scene.bodies)
    return not (
        scene.forces or held or changing(scene) or scene.contact.get('mode', 'none') != 'none'
    )


def _refusal(scene: Scene, integrator: Integrator) -> str | None:
    reason = integrator.refuses(scene)
    if reason is None and scene.contact.get('mode', 'none') != 'none':
        from rigid_body_sim.physics.contact.suited_integrators import unsuited  # where asked for

        return unsuited(integrator)
    return reason
