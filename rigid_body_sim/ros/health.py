# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
How a run does: what /diagnostics says, and the sentence at the end. No message type is known here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field

from rigid_body_sim.physics.diagnostics.conserved_groups import KeptQuantity
from rigid_body_sim.physics.diagnostics.energy_balance import EnergyBalance
from rigid_body_sim.physics.diagnostics.invariants import Drift
from rigid_body_sim.ros.lockstep import LockstepFigures
from rigid_body_sim.runs.error_estimate import ErrorEstimate
from rigid_body_sim.runs.kept_lines import defect_words

BEHIND = 0.95  # share of the requested real-time factor below which a run is called slow
OK, WARN, ERROR = 0, 1, 2
SCENE_BEGAN = 'scene began [s]'  # by which `state_listener` knows of a reset
BALANCE = ('change', 'work_of_commands', 'work_of_drives', 'dissipation', 'contact', 'defect',
           'uncertainty')  # fmt: skip


@dataclass(frozen=True)
class Health:
    """
    The figures of one moment.

    pauses               : how often it was paused, at its start too
    scene_began          : [s] of simulated time: 0, or the last reset
    factor_asked         : real-time factor asked for; 0: as fast as possible
    factor               : reached in the last period, at least in a second
    overruns, lags       : see `Pacer`
    largest_lateness, last_lateness : [s]
    accepted, refused    : commands; refused ones by reason
    lost                 : commands that never came, as far as the middleware tells; None: there
                           are too many topics to ask
    unread               : commands that had come when the run ended, and that it did not look at
    bag                  : what is recorded to; empty when nothing is
    deepest_gap          : smallest distance of two bodies in contact [m], negative: they
                           overlapped; None where nothing touched
    balance              : of the energy, since the start, the last reset or the begin of the bag
    kept                 : of groups of bodies, where the whole does not keep its momentum
    estimate             : estimated error of the states, if asked for
    warnings             : limits of the integrator that the run has passed
    integrator           : what the run goes on with now
    looks                : what `auto` saw on the way, in words
    failure              : why the run ended, if it failed
    lockstep             : what it waits for; None where it waits for nobody
    """

    scene: str
    tick: int
    time: float
    paused: bool
    factor_asked: float
    factor: float
    overruns: int
    lags: int
    largest_lateness: float
    last_lateness: float
    accepted: int
    last_refusal: str
    drift: Drift
    bag: str
    deepest_gap: float | None = None
    balance: EnergyBalance | None = None
    kept: Sequence[KeptQuantity] = ()
    refused: Mapping[str, int] = field(default_factory=dict)
    estimate: ErrorEstimate | None = None
    warnings: Sequence[str] = ()
    integrator: str = ''
    looks: str = ''
    failure: str = ''
    lost: int | None = 0
    unread: int = 0
    lockstep: LockstepFigures | None = None
    pauses: int = 0
    scene_began: float = 0.0

    @property
    def level(self) -> int:
        """
        OK, WARN when the run is slower than asked or was beyond a limit, ERROR when it failed.
        """
        if self.failure:
            return ERROR
        return WARN if self._is_slow or self.warnings or self._of_lockstep else OK

    @property
    def _of_lockstep(self) -> str:
        return self.lockstep.warning if self.lockstep else ''

    @property
    def _is_slow(self) -> bool:
        if self.paused or self.lockstep:  # where the factor is an upper bound
            return False
        return self.factor < BEHIND * self.factor_asked

    @property
    def message(self) -> str:
        """One sentence."""
        if self.failure:
            return self.failure
        said = 'paused' if self.paused else 'running'
        if self._is_slow:
            said = (
                f'slower than asked: real-time factor {self.factor:.3f} of {self.factor_asked:g}'
            )
        if self.lockstep and self.lockstep.timed_out:
            return '; '.join([self._of_lockstep, *self.warnings[:1]])
        return '; '.join(filter(None, [said, self._of_lockstep, *self.warnings[:1]]))

    def values(self) -> dict[str, str]:
        """Every figure by name, as text."""
        texts = {
            'tick': str(self.tick),
            'time [s]': f'{self.time:.9f}',
            SCENE_BEGAN: f'{self.scene_began:.9f}',
            'real-time factor': f'{self.factor:.4f}',
            'real-time factor asked': f'{self.factor_asked:g}',
            'overruns': str(self.overruns),
            'lags': str(self.lags),
            'pauses': str(self.pauses),
            'largest lateness [s]': f'{self.largest_lateness:.6f}',
            'last lateness [s]': f'{self.last_lateness:.6f}',
            'accepted commands': str(self.accepted),
            'refused commands': str(sum(self.refused.values())),
            'last refusal': self.last_refusal,
            'lost commands': 'too many topics to count' if self.lost is None else str(self.lost),
            'energy drift': _drift(self.drift.energy),
            'momentum drift': _drift(self.drift.momentum),
            'angular momentum drift': _drift(self.drift.angular_momentum),
            'recording': self.bag,
            'integrator': self.integrator,
        }
        if self.unread:
            texts['unread commands'] = str(self.unread)
        if self.lockstep is not None:
            texts |= self.lockstep.values()
        texts |= self._balance_values()
        if self.looks:
            texts['auto'] = self.looks
        if self.drift.energy_rise is not None:
            texts['energy rise'] = f'{self.drift.energy_rise:.3e}'
        if self.deepest_gap is not None:
            texts['deepest gap [m]'] = f'{self.deepest_gap:.3e}'
        if self.estimate is not None:
            for name, value in self.estimate.figures().items():
                text = f'{value:.3e}' if isinstance(value, float) else str(value)
                texts[f'estimated error: {name.replace("_", " ")}'] = text
        texts |= {f'warning {i}': text for i, text in enumerate(self.warnings, start=1)}
        return texts | {f'refused: {reason}': str(n) for reason, n in self.refused.items()}

    def _balance_values(self) -> dict[str, str]:
        """The energy balance, and the worst drift of each law of groups."""
        texts: dict[str, str] = {}
        if self.balance is not None:
            texts = {
                f'energy balance: {name.replace("_", " ")} [J]': f'{value:.6e}'
                for name, value in asdict(self.balance).items()
                if name in BALANCE
            }
            texts['energy balance: defect in words'] = defect_words(self.balance)
        worst: dict[str, KeptQuantity] = {}
        if self.drift.momentum is None:
            for law in sorted(self.kept, key=lambda law: law.drift):
                worst[law.quantity] = law
        for quantity, law in worst.items():
            texts[f'{quantity} drift, worst of groups'] = f'{law.drift:.3e} ({law.bodies[0]})'
        return texts

    def summary(self) -> str:
        """What to say when it is over."""
        return (
            f'{self.tick} ticks, {self.time:g} s; {self._pauses()}overruns {self.overruns}, lags '
            f'{self.lags}, largest lateness {self.largest_lateness * 1e3:.3f} ms, last '
            f'{self.last_lateness * 1e3:.3f} ms; commands {self.accepted}, refused '
            f'{sum(self.refused.values())}{f", lost {self.lost}" if self.lost else ""}'
            f'{f", unread at the end {self.unread}" if self.unread else ""}; '
            f'{self._energy()}'
        )

    def _pauses(self) -> str:
        said = [f'paused {self.pauses} time{"s" * (self.pauses != 1)}'] if self.pauses else []
        if self.paused:
            said.append('standing at the end')
        return f'{", ".join(said)}; ' if said else ''

    def _energy(self) -> str:
        """What to say of the energy: its defect; where bodies meet, that it must not rise."""
        said = []
        if self.balance is not None:
            said.append(f'energy defect {self.balance.defect:.3e} J')
        if self.drift.energy is not None:
            said.append(f'energy drift {_drift(self.drift.energy)}')
        if self.drift.energy_rise is not None:
            said.append(f'energy rise {self.drift.energy_rise:.3e}')
            if self.deepest_gap is not None:
                said.append(f'deepest gap {self.deepest_gap:.3e} m')
        return ', '.join(said)


def _drift(drift: float | None) -> str:
    return 'not conserved in this scene' if drift is None else f'{drift:.3e}'
