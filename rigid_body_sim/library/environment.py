# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
A scene as an environment of gymnasium: one body is commanded, its state is observed.

    env = BodyEnv('satellite', body='satellite', torque=0.5, every=0.1, reward=turning_less)
    observation, info = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

    observation : (13,) position [m], orientation xyzw, velocity [m/s], angular velocity [rad/s]
                  (world axes, centre of mass); (6,) position and velocity of a point mass
    action      : in [-1, 1], times the limits: force x, y, z if there is one, then torque x, y, z,
                  held over `every` in body axes (world axes for a point mass)

What an agent should do is said by functions of the state (`StateOfBody`): `reward(state, action)`
and `terminated(state)`, and where a run begins by `start(rng)`, which returns the arguments of
`Simulation.set_state`; the generator is that of `reset(seed=…)`, so equal seeds give equal runs.
gymnasium is the extra `gym`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.library.simulation import AnyScene, Simulation
from rigid_body_sim.missing_packages import missing
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged
from rigid_body_sim.physics.model.numbers import number
from rigid_body_sim.physics.model.tick_length import whole_ticks
from rigid_body_sim.physics.state.snapshot import StateOfBody
from rigid_body_sim.scene import load_scene

try:
    from gymnasium import Env, spaces
except ModuleNotFoundError as _error:
    raise UserError(missing(_error.name or 'gymnasium')) from None

Array = np.ndarray
NOTHING = (0.0, 0.0, 0.0)
Reward = Callable[[StateOfBody, Array], float]
Start = Callable[[np.random.Generator], Mapping[str, Any]]


def turning_less(state: StateOfBody, action: Array) -> float:
    """Reward rest: minus |omega|^2 [rad^2/s^2] and a hundredth of |action|^2."""
    spin = state.angular_velocity
    return -float(spin @ spin) - 0.01 * float(action @ action)


class BodyEnv(Env):
    """
    See the module.

    scene : as of `Simulation`
    body  : name of the body that is commanded and observed
    force, torque : [N], [N m] largest of each component; 0: not commanded
    every    : [s] between actions, a whole number of ticks
    duration : [s] after which a run is truncated
    reward, terminated, start : see the module; without `start` every run begins as the scene says
    """

    metadata: ClassVar[dict[str, Any]] = {'render_modes': []}  # pyright: ignore[reportIncompatibleVariableOverride]

    def __init__(
        self,
        scene: AnyScene,
        body: str,
        *,
        force: float = 0.0,
        torque: float = 0.0,
        every: float = 0.05,
        duration: float = 10.0,
        reward: Reward = turning_less,
        terminated: Callable[[StateOfBody], bool] = lambda _state: False,
        start: Start | None = None,
        integrator: str | None = None,
    ) -> None:
        scene = load_scene(scene) if isinstance(scene, str | bytes | Mapping) else scene
        self.simulation = Simulation(scene, integrator=integrator)
        self._body = body
        self._index = self.simulation.body_index(body)
        self._is_point = self.simulation.scene.bodies[self._index].is_point
        limits = [
            *[number(force, unit='N', minimum=0.0)] * 3 * (force != 0.0),
            *[number(torque, unit='N m', minimum=0.0)] * 3 * (torque != 0.0),
        ]
        if not limits or (self._is_point and torque):
            raise InvalidModel(
                f'environment of {body!r}: force {force} N, torque {torque} N m; one at least is '
                'commanded, and of a point mass a force alone'
            )
        self._limits, self._pushes = np.array(limits), bool(force)
        self._ticks = whole_ticks(every, self.simulation.dt_ns, what='every')
        if self._ticks < 1:
            raise InvalidModel(f'every: {every} s is less than a tick')
        self._last = whole_ticks(duration, self.simulation.dt_ns, what='duration')
        self._reward, self._terminated, self._start = reward, terminated, start
        size = 6 if self._is_point else 13
        self.observation_space = spaces.Box(-np.inf, np.inf, (size,), np.float64)
        self.action_space = spaces.Box(-1.0, 1.0, (len(limits),), np.float64)
        self._begun = 0  # [tick]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Begin a run; `seed` renews the generator that `start` is given."""
        super().reset(seed=seed)
        self.simulation.reset()
        self._begun = self.simulation.tick
        if self._start is not None:
            self.simulation.set_state(self._body, **self._start(self.np_random))
        return self._observed(), self._told()

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action over `every`; a run that diverges is terminated, with reward -inf."""
        action = np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        asked = action * self._limits
        force = asked[:3].tolist() if self._pushes else NOTHING
        torque = asked[-3:].tolist() if len(asked) > 3 or not self._pushes else NOTHING
        frame = 'world' if self._is_point else 'body'
        self.simulation.set_wrench(self._body, force=force, torque=torque, frame=frame)
        try:
            self.simulation.step(self._ticks)
        except SimulationDiverged as error:
            return self._observed(), -np.inf, True, False, self._told() | {'problem': str(error)}
        state = self.simulation.state[self._body]
        done = self.simulation.tick - self._begun >= self._last
        reward = float(self._reward(state, action))
        return self._observed(), reward, bool(self._terminated(state)), done, self._told()

    def _observed(self) -> Array:
        state = self.simulation.state[self._body]
        if self._is_point:
            return np.concatenate((state.position, state.velocity))
        turning = (state.orientation, state.velocity, state.angular_velocity)
        return np.concatenate((state.position, *turning))

    def _told(self) -> dict[str, Any]:
        return {'time': (self.simulation.tick - self._begun) * self.simulation.dt}
