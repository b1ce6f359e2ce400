# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A scene that moves: whole ticks, commands at tick boundaries, and what can be asked of it.

    sim = Simulation(load_scene('box.yaml'))
    sim.set_wrench('box', force=(1, 0, 0))
    sim.step(1000)
    sim.state.position

Time is tick * dt_ns in integers. `step(1000)` and a thousand times `step()` give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rigid_body_sim.physics import rotation as so3
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.held_wrenches import FOREVER, HeldWrenches, Slot
from rigid_body_sim.physics.integrators import INTEGRATORS
from rigid_body_sim.physics.invariants import Invariants
from rigid_body_sim.physics.layout import Layout
from rigid_body_sim.physics.model import Scene, Vector
from rigid_body_sim.physics.state import State, StateReader
from rigid_body_sim.physics.stepper import Stepper
from rigid_body_sim.physics.tick_length import tick_nanoseconds

Array = NDArray[np.float64]

NO_VECTOR: Vector = (0.0, 0.0, 0.0)
FRAMES = ('world', 'body')


class Simulation:
    """
    One run of one scene.

    scene      : what `rigid_body_sim.load_scene` returns
    integrator : name in `physics.integrators.INTEGRATORS`; None: the scene's
    dt         : [s] a whole number of nanoseconds; None: the scene's

    Raises InvalidModel for an unknown integrator or an impossible dt.
    """

    def __init__(
        self, scene: Scene, *, integrator: str | None = None, dt: float | None = None
    ) -> None:
        name = integrator or scene.integrator
        if name not in INTEGRATORS:
            allowed = ', '.join(sorted(INTEGRATORS))
            raise InvalidModel(f'integrator {name!r} is unknown; choose one of: {allowed}')
        self.scene = scene
        self.integrator = INTEGRATORS[name]
        self.dt_ns = scene.dt_ns if dt is None else tick_nanoseconds(dt)
        self.tick = 0
        self.invariants = Invariants(scene)
        self._layout = Layout(scene)
        self._reader = StateReader(self._layout)
        self._held = HeldWrenches(self._layout, scene.gravity)
        self._stepper = Stepper(scene, self._layout, self.integrator)
        self._read: State | None = None
        self._held_changed = True

    @property
    def time(self) -> float:
        """Simulated time [s]: tick * dt_ns * 1e-9."""
        return self.tick * self.dt_ns * 1e-9

    @property
    def dt(self) -> float:
        """Tick length [s]."""
        return self.dt_ns / 1e9

    @property
    def state(self) -> State:
        """Position, orientation and velocities of every body, scene order: a copy."""
        if self._read is None:
            self._read = self._reader.read(self._stepper.translation, self._stepper.rotation)
        return self._read

    def prepare(
        self, *, commands_in_body_axes: bool = False, progress: Callable[[str], None] | None = None
    ) -> None:
        """
        Compile now what stepping will need, so that no tick has to wait for it.

        commands_in_body_axes : also what commands in body axes will need
        progress              : called with a short text before each part
        """
        self._stepper.prepare(commands_in_body_axes=commands_in_body_axes, progress=progress)
        if progress is not None:
            progress('reading states')
        _ = self.state

    def step(self, ticks: int = 1) -> None:
        """
        Advance by whole ticks.

        Raises SimulationDiverged when a state leaves the finite numbers; `tick` and `state` are then the last good ones.
        """
        end = self.tick + ticks
        while self.tick < end:
            self._drop_expired()
            if self._held_changed:
                self._stepper.hold(self._held.write(self._stepper.translation, self._stepper.rotation))
                self._held_changed = False
            chunk = min(end, self._held.next_expiry()) - self.tick if self._held.slots else end - self.tick
            self._read = None
            done = self._stepper.advance(chunk, self.tick, self.dt)
            self.tick += done
            if done < chunk:
                raise self._diverged()

    def _drop_expired(self) -> None:
        if self._held.slots and self._held.drop_expired(self.tick):
            self._held_changed = True

    def _diverged(self) -> SimulationDiverged:
        core = self._stepper.first_diverged()
        return SimulationDiverged(
            body=self._layout.body(core).name,
            tick=self.tick,
            cause=f'its state is no longer finite; with {self.integrator.name} at dt = {self.dt:g} s the limits are: '
            f'{self.integrator.stability}; take a smaller dt or another integrator',
        )

    def set_wrench(
        self,
        body: str,
        *,
        force: Sequence[float] = NO_VECTOR,
        torque: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> None:
        """
        Hold a force and a torque on a body until changed; it acts from the next tick on.

        force  : (3,) [N]    at the centre of mass
        torque : (3,) [N m]
        frame  : 'world', or 'body': axes that turn with the body
        """
        self.hold(body, 'wrench', force=force, torque=torque, frame=frame)

    def hold(
        self,
        body: str,
        source: str,
        *,
        force: Sequence[float] = NO_VECTOR,
        torque: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
        until: int = FOREVER,
    ) -> None:
        """
        Hold what one source asks of a body in place of what it asked before; sources add.

        source : 'force', 'torque' or 'wrench'
        until  : [tick] first tick on which it no longer acts
        """
        core, force, torque = self._checked(body, force, torque, frame)
        if frame == 'body':
            force = self._layout.principal_axes(body, force)
            torque = self._layout.principal_axes(body, torque)
        self._held.set(core, source, Slot(force, torque, frame == 'body', until))
        self._held_changed = True

    def apply_impulse(
        self,
        body: str,
        *,
        linear: Sequence[float] = NO_VECTOR,
        angular: Sequence[float] = NO_VECTOR,
        frame: str = 'world',
    ) -> tuple[Vector, Vector]:
        """
        Change momentum and angular momentum at once, whatever dt is.

        linear  : (3,) [N s]    at the centre of mass
        angular : (3,) [N m s]
        returns : both in world axes
        """
        core, linear, angular = self._checked(body, linear, angular, frame)
        if frame == 'body':
            self._layout.principal_axes(body, linear)  # refuses a point mass
            q = self.state.orientation[self._layout.index(body)]
            linear = tuple(so3.rotate(q, linear).tolist())
            angular = tuple(so3.rotate(q, angular).tolist())
        self._stepper.strike(core, linear, angular)
        self._read = None
        return linear, angular

    def _checked(
        self, body: str, force: Sequence[float], torque: Sequence[float], frame: str
    ) -> tuple[int, Vector, Vector]:
        core = self._layout.core(body)
        if frame not in FRAMES:
            raise InvalidModel(f"command to {body!r}: frame {frame!r}; allowed: 'world', 'body'")
        force, torque = _vector(body, 'force', force), _vector(body, 'torque', torque)
        if core >= self._layout.n_rigid and any(torque):
            raise InvalidModel(
                f'command to {body!r}: torque {torque} on a point mass, which has no orientation; '
                'give a force only, or give the body a shape with extent'
            )
        return core, force, torque

    def applied_wrench(self) -> tuple[Array, Array]:
        """
        Force [N] and torque [N m] that commands exert on each body at the start of the coming tick.

        returns : (n, 3) and (n, 3), scene order, world axes; without gravity and force elements
        """
        self._drop_expired()
        force, torque, table = self._held.sums()
        of_scene = np.zeros((2, len(self.scene.bodies), 3))
        of_scene[0, self._layout.moving] = force
        of_scene[1, self._layout.moving] = torque
        for row in table:
            core = int(row[0])
            q = self._stepper.orientation(core)
            scene_index = int(self._layout.moving[core])
            of_scene[0, scene_index] += so3.rotate(q, row[2:5])
            of_scene[1, scene_index] += so3.rotate(q, row[5:8])
        return of_scene[0], of_scene[1]

    def energy(self) -> float:
        """Kinetic and potential energy [J]."""
        return self.invariants.energy(self.state)

    def momentum(self) -> Array:
        """Total momentum (3,) [kg m/s]."""
        return self.invariants.momentum(self.state)

    def angular_momentum(self) -> Array:
        """Total angular momentum about the origin of the world (3,) [kg m^2/s]."""
        return self.invariants.angular_momentum(self.state)

    def reset(self) -> None:
        """Put every body back to the start of the scene and let go of all commands; time goes on."""
        self._stepper.reset()
        self._held.slots.clear()
        self._held_changed = True
        self._read = None

    @property
    def next_expiry(self) -> int:
        """First tick on which a held command ends."""
        return self._held.next_expiry()

    @property
    def has_turning_commands(self) -> bool:
        """Whether a command holds in the axes of a body."""
        return any(slot.turns_with_body for slot in self._held.slots.values())

    @property
    def held_slots(self) -> dict[tuple[int, str], Slot]:
        """Commands that hold, by (core index, source): a copy."""
        return dict(self._held.slots)

    def state_bytes(self) -> bytes:
        """Give everything the next tick depends on, but for commands: float64 little endian, core order."""
        return self._layout.state_bytes(self._stepper.translation, self._stepper.rotation)

    def restore(self, *, tick: int, state: bytes, slots: dict[tuple[int, str], Slot]) -> None:
        """Go on from a tick, a state of `state_bytes` and the commands that held then."""
        self._layout.set_state_bytes(state, self._stepper.translation, self._stepper.rotation)
        self.tick = tick
        self._held.slots = dict(slots)
        self._held_changed = True
        self._read = None


def _vector(body: str, what: str, values: Any) -> Vector:
    numbers = np.asarray(values, dtype=np.float64)
    if numbers.shape != (3,) or not np.all(np.isfinite(numbers)):
        raise InvalidModel(f'command to {body!r}: {what} {values!r}; allowed: three finite numbers')
    x, y, z = numbers.tolist()
    return (x, y, z)
