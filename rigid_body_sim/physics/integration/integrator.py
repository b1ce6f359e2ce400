# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an integrator says of itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics.forces.evaluator import Derivatives
from rigid_body_sim.physics.integration.limits import Limits
from rigid_body_sim.physics.integration.options import Option, checked
from rigid_body_sim.physics.model.inertia_over_time import changing
from rigid_body_sim.physics.model.scene import Scene
from rigid_body_sim.physics.state.layout import Layout

Array = NDArray[np.float64]


class Scheme(Protocol):
    """
    How a tick is made: see `schemes`.

    The kernels share one signature: (ticks, tick, h, n_bodies, n_rigid, translation, rotation,
    method, workspace, elements, ranges) -> DONE, NaN if a number left the finite ones, or
    DID_NOT_CONVERGE.
    """

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        ...

    def coupled(
        self, name: str, *, scene: str, evaluate: Callable[..., Any], velocity_dependent: bool
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        ...

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        ...


class ImplicitScheme(Protocol):
    """A scheme that also asks how the forces change: `Integrator.wants_derivatives`."""

    def free(self, name: str) -> Callable[..., Any]:
        """Make the kernel for a scene without forces that depend on the state."""
        ...

    def coupled(
        self,
        name: str,
        *,
        scene: str,
        evaluate: Callable[..., Any],
        velocity_dependent: bool,
        derivatives: Derivatives,
    ) -> Callable[..., Any]:
        """Make the kernel for the force elements of a scene, named by `scene`."""
        ...

    def workspace(self, blocks: int) -> int:
        """Count the numbers that a step writes beside the state."""
        ...


def no_coefficients(moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return no numbers: the method needs none of its own per body."""
    return np.zeros((len(moments), 0))


def no_refusal(_scene: Scene) -> str | None:
    """Refuse no scene."""
    return None


@dataclass(frozen=True)
class NeedsSteadyInertia:
    """
    The refusals of a method that does not follow an inertia over time (`model.inertia_over_time`).

    name : of the method
    own  : its other refusals
    """

    name: str
    own: Callable[[Scene], str | None]

    def __call__(self, scene: Scene) -> str | None:
        """Tell why the method must not be used on a scene, or None."""
        for body in changing(scene):
            return (
                f'the inertia of {body.name!r} changes over time, which {self.name} does not '
                'follow; take lie_rk4, or a Runge–Kutta method with orientation: matrix'
            )
        return self.own(scene)


@dataclass(frozen=True)
class Integrator:
    """
    One time integration method.

    name         : what a scene calls it
    order        : power of h in the global error with smooth forces; infinite where it is exact
    free_order   : the same for the attitude of a body on which no torque acts
    keeps        : what it conserves, in words
    stability    : its limit, in words
    source       : where it comes from
    coefficients : (n, 3) principal moments -> (n, rows) numbers per body that the kernel wants at
                   hand
    refuses      : scene -> why this method must not be used on it and which one may, or None
    plan         : (scene, layout, h) -> workspace with what the kernels want to know of the scene,
                   once for each h
    wants_derivatives : whether `scheme.coupled` also takes `derivatives`: see `forces.derivatives`
    failure      : what has happened when its kernel returns DID_NOT_CONVERGE
    options      : what a scene may set, by name
    configure    : (integrator, every option with its value) -> the integrator that obeys them
    settings     : the options with their values
    constants    : numbers that its kernel finds at the head of the workspace
    remembers    : (n, 4) quaternions -> (n, rows) part of the state that the blocks do not hold,
                   in place of coefficients; None where they hold it all
    is_reference : made for comparison: runs in Python, tick by tick, slowly
    limits       : its limits, in numbers
    follows_inertia : whether its stages ask for the inertia of their instant
    """

    name: str
    order: float
    free_order: float
    keeps: str
    stability: str
    source: str
    scheme: Scheme | ImplicitScheme
    coefficients: Callable[[NDArray[np.float64]], NDArray[np.float64]] = no_coefficients
    refuses: Callable[[Scene], str | None] = no_refusal
    plan: Callable[[Scene, Layout, float], NDArray[np.float64]] | None = None
    wants_derivatives: bool = False
    failure: str = 'Newton iteration did not converge'
    options: Mapping[str, Option] = field(default_factory=dict)
    configure: Callable[[Integrator, Mapping[str, Any]], Integrator] | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    constants: tuple[float, ...] = ()
    remembers: Callable[[Array], Array] | None = None
    is_reference: bool = False
    limits: Limits = field(default_factory=Limits)
    follows_inertia: bool = False

    @property
    def controls_its_error(self) -> bool:
        """Whether it chooses its steps: tolerances and not the tick set the error."""
        return 'rtol' in self.options

    def configured(self, given: Mapping[str, Any]) -> Integrator:
        """
        Set options; those not given have their defaults.

        Raises InvalidModel for an unknown option or an impossible value.
        """
        settings = checked(self.name, self.options, given)
        configured = self if self.configure is None else self.configure(self, settings)
        refuses = configured.refuses
        if configured.follows_inertia and isinstance(refuses, NeedsSteadyInertia):
            refuses = refuses.own
        return replace(configured, settings=settings, refuses=refuses)

    @property
    def substeps(self) -> int:
        """Count the steps that make a tick."""
        return int(self.settings.get('substeps', 1))


def within_tolerances(integrator: Integrator, settings: Mapping[str, Any]) -> Integrator:
    """Hand the tolerances to the kernel, which finds them at the head of the workspace."""
    return replace(integrator, constants=(settings['rtol'], settings['atol']))
