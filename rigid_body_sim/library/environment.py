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
and `terminated(state)`, and where a run begins by `start(rng)`, the arguments of `set_state`; the
generator is that of `reset(seed=…)`, so equal seeds give equal runs. A run that leaves `reach` or
diverges is terminated, its observation cut off there; `info['problem']` says why.
gymnasium is the extra `gym`; there it is `gymnasium.make(ID, scene=…, body=…, torque=…)`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np

from rigid_body_sim.errors import UserError
from rigid_body_sim.library.simulation import AnyScene, Simulation
from rigid_body_sim.missing_packages import missing
from rigid_body_sim.physics.errors import InvalidModel, SimulationDiverged, choose_from
from rigid_body_sim.physics.model.numbers import array_of_numbers, number, shown
from rigid_body_sim.physics.model.tick_length import whole_ticks
from rigid_body_sim.physics.state.snapshot import StateOfBody

try:
    from gymnasium import Env, register, spaces
    from gymnasium.envs.registration import EnvSpec
except ModuleNotFoundError as _error:
    raise UserError(missing(_error.name or 'gymnasium')) from None

Array = np.ndarray
NOTHING = (0.0, 0.0, 0.0)
ID, ENTRY = 'rigid_body_sim/Body-v0', 'rigid_body_sim:BodyEnv'
Reward = Callable[[StateOfBody, Array], float]
OF_START = ('position', 'orientation', 'velocity', 'angular_velocity', 'frame')
CALLED = {
    'reward': 'reward(state, action), which gives a number',
    'terminated': 'terminated(state), which gives a truth value',
    'start': 'start(rng), which gives arguments of set_state, or None',
}
Start = Callable[[np.random.Generator], Mapping[str, Any]]


def turning_less(state: StateOfBody, action: Array) -> float:
    """Reward rest: minus |omega|^2 [rad^2/s^2] and a hundredth of |action|^2."""
    spin = state.angular_velocity
    return -float(spin @ spin) - 0.01 * float(action @ action)


def never(_state: StateOfBody) -> bool:
    """Terminate at no state."""
    return False


def _number(said: str, value: Any, *, unit: str, minimum: float) -> float:
    try:
        return number(value, unit=unit, minimum=minimum)
    except InvalidModel as error:
        raise InvalidModel(f'{said}: {error}') from None


def _check_functions(said: str, **given: Any) -> None:
    """Refuse, before a run, what cannot be called in it."""
    for name, function in given.items():
        if not callable(function) and not (name == 'start' and function is None):
            raise InvalidModel(
                f'{said}: {name}: got {shown(function)}; allowed: a function, {CALLED[name]}'
            )


class BodyEnv(Env):
    """
    See the module.

    scene : as of `Simulation`
    body  : name of the body that is commanded and observed
    force, torque : [N], [N m] largest of each component; 0: not commanded
    every    : [s] between actions, a whole number of ticks
    duration : [s] after which a run is truncated
    reach    : [m], [m/s], [rad/s] largest of each component that is observed
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
        reach: float = 1e6,
        reward: Reward = turning_less,
        terminated: Callable[[StateOfBody], bool] = never,
        start: Start | None = None,
        integrator: str | Mapping[str, Any] | None = None,
    ) -> None:
        told = dict(locals())
        del told['self']
        self.spec = EnvSpec(ID, entry_point=ENTRY, kwargs=told)
        self.simulation = Simulation(scene, integrator=integrator)
        self._body, index = body, self.simulation.body_index(body)
        self._is_point = self.simulation.scene.bodies[index].is_point
        said = self._said = f'environment of {body!r}'
        largest = [
            _number(f'{said}: {name}', value, unit=unit, minimum=0.0)
            for name, value, unit in (('force', force, 'N'), ('torque', torque, 'N m'))
        ]
        limits = [limit for limit in largest if limit for _ in range(3)]
        if not limits or (self._is_point and torque):
            asked = f'{said}: force {force} N, torque {torque} N m; '
            raise InvalidModel(asked + 'one at least is commanded, of a point mass a force alone')
        _check_functions(said, reward=reward, terminated=terminated, start=start)
        self._limits, self._pushes = np.array(limits), bool(force)
        self._ticks = whole_ticks(every, self.simulation.dt_ns, what=f'{said}: every')
        if self._ticks < 1:
            raise InvalidModel(
                f'{said}: every: {every} s; allowed: from one tick of {self.simulation.dt:g} s on'
            )
        self._last = whole_ticks(duration, self.simulation.dt_ns, what=f'{said}: duration')
        self._reward, self._terminated, self._start = reward, terminated, start
        furthest = _number(f'{said}: reach', reach, unit='m', minimum=1.0)
        most = np.full(6 if self._is_point else 13, furthest)
        most[3 : len(most) - 6] = 1.0  # of a quaternion
        self._most, self.observation_space = most, spaces.Box(-most, most, dtype=np.float64)
        self.action_space = spaces.Box(-1.0, 1.0, (len(limits),), np.float64)
        self._begun = 0  # [tick]

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Array, Any]:
        """Begin a run; `seed` renews the generator that `start` is given."""
        super().reset(seed=seed)
        self.simulation.reset()
        self._begun = self.simulation.tick
        if self._start is not None:
            self.simulation.set_state(self._body, **self._asked_start(self._start))
        return self._observed()[0], self._told()

    def _asked_start(self, start: Start) -> dict[str, Any]:
        """Give the arguments of `set_state` where a run begins."""
        asked = start(self.np_random)
        if not isinstance(asked, Mapping):
            raise InvalidModel(
                f'{self._said}: start: gave {shown(asked)}; allowed: a mapping with '
                f'{", ".join(OF_START)}, as far as they are not as the scene says'
            )
        for key in asked:
            if key not in OF_START:
                raise InvalidModel(
                    f'{self._said}: start: gave {shown(key)}{choose_from(key, OF_START)}'
                )
        return dict(asked)

    def step(self, action: Any) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold an action over `every`; a run that diverges has reward -inf."""
        given = array_of_numbers(action)
        if given is None or given.shape != self._limits.shape or not np.isfinite(given).all():
            shape = '' if given is None else f' of shape {given.shape}'
            raise InvalidModel(
                f'action of {self._body!r}: got {shown(action)}{shape}; '
                f'allowed: finite numbers {self._limits.shape}, as action_space.sample() gives '
                'them; they are cut off at -1 and 1'
            )
        action = np.clip(given, -1.0, 1.0)
        asked = action * self._limits
        force = asked[:3].tolist() if self._pushes else NOTHING
        torque = asked[-3:].tolist() if len(asked) > 3 or not self._pushes else NOTHING
        frame = 'world' if self._is_point else 'body'
        self.simulation.set_wrench(self._body, force=force, torque=torque, frame=frame)
        try:
            self.simulation.step(self._ticks)
        except SimulationDiverged as error:
            return self._observed()[0], -np.inf, True, False, self._told(str(error))
        state = self.simulation.state[self._body]
        done = self.simulation.tick - self._begun >= self._last
        reward = float(self._reward(state, action))
        observation, has_left = self._observed()
        told = self._told(f'{self._body!r} left its reach' if has_left else '')
        return observation, reward, has_left or bool(self._terminated(state)), done, told

    def _observed(self) -> tuple[Array, bool]:
        """Give the observation, and whether it was cut off."""
        s, most = self.simulation.state[self._body], self._most
        turning = () if self._is_point else (s.orientation, s.velocity, s.angular_velocity)
        whole = np.concatenate((s.position, *(turning or (s.velocity,))))
        return np.clip(whole, -most, most), bool(np.any(np.abs(whole) > most * (1.0 + 1e-9)))

    def _told(self, problem: str = '') -> dict[str, Any]:
        time = (self.simulation.tick - self._begun) * self.simulation.dt
        return {'time': time, 'problem': problem} if problem else {'time': time}


register(ID, entry_point=ENTRY)
