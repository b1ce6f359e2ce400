# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
What tests see of the inside of the package: the only module of the tests that names what is
private there, so that a change inside is followed here and nowhere else.
"""

import argparse
import fcntl
import gc
import os
import sys
from contextlib import contextmanager

import numpy as np
import yaml

from rigid_body_sim.physics import stepper as stepper_module
from rigid_body_sim.physics.compile import kernels
from rigid_body_sim.physics.compile.images import Images
from rigid_body_sim.physics.compile.kernel import Kernel, behind
from rigid_body_sim.physics.compile.pieces import PieceFiles
from rigid_body_sim.physics.contact import step, tick_counts, world_arrays
from rigid_body_sim.physics.contact import world as world_module
from rigid_body_sim.physics.contact.collision.collider import BOX, PLANE, SPHERE, SURFACE
from rigid_body_sim.physics.contact.islands import unsettled_record
from rigid_body_sim.physics.contact.islands.sleep import make_sleep_state
from rigid_body_sim.physics.contact.settings import EVENT
from rigid_body_sim.physics.contact.solver import batch_record
from rigid_body_sim.physics.contact.solver.iterations import solver
from rigid_body_sim.physics.contact.world import ContactWorld
from rigid_body_sim.physics.forces import held_wrenches
from rigid_body_sim.physics.forces.acting_elements import ActingElements
from rigid_body_sim.physics.forces.elements import FORCES, held_body_wrench
from rigid_body_sim.physics.forces.tables import stacked
from rigid_body_sim.physics.integration import integrators
from rigid_body_sim.physics.state import snapshot
from rigid_body_sim.physics.stepper import Stepper
from rigid_body_sim.scene import document

PAIRS = tuple((a, b) for a in range(PLANE) for b in range(a, PLANE + 1))  # ground aside
ALL_PAIRS = (*PAIRS, *((kind, SURFACE) for kind in range(PLANE)))
EVENT_PAIRS = (*PAIRS, (SPHERE, SURFACE), (BOX, SURFACE))
USUAL_FORCES = {'constant', 'drag', 'spring'}  # those of test_compiled_is_plain
FORCES_BESIDE_CONTACT = {*USUAL_FORCES, 'gravity', 'time'}


def stepper(simulation):
    """
    The arrays of a simulation and the kernels that advance them.
    """
    return simulation._stepper


def layout(simulation):
    """
    Where bodies stand in the arrays.
    """
    return simulation._layout


def elements(simulation):
    """
    Everything that acts in a simulation.
    """
    return simulation._stepper._elements


def parts_of_step(simulation):
    """
    The calls that a step is made of where it goes on several threads.
    """
    return simulation._stepper._parts


def with_commands(simulation):
    """
    The same simulation with what is held in its arrays, as before a tick.
    """
    simulation._take_held()
    return simulation


def rows_of_method(simulation):
    """
    Numbers per body that the integrator has at hand.
    """
    return simulation._stepper._method


def kernels_of(simulation):
    """
    The kernels of a simulation, without and with what depends on the state.
    """
    return simulation._stepper._free_kernel(), simulation._stepper._coupled_kernel()


def advance_by(simulation, kernel):
    """
    Take another kernel for the one with what depends on the state.
    """
    simulation._stepper._coupled = kernel


def contact(simulation):
    """
    The contact of a simulation.
    """
    return simulation._stepper.contact


def world(simulation):
    """
    The arrays of the contact of a simulation.
    """
    return contact(simulation).arrays


def known_pairs(simulation):
    """
    The pairs of types that the kernel of a simulation knows.
    """
    return contact(simulation)._kinds


def shorten(simulation, **lengths):
    """
    Cut arrays of contact to a length each.
    """
    arrays = world(simulation)
    for name, length in lengths.items():
        setattr(arrays, name, getattr(arrays, name)[:length])
    arrays.pack()


def watch_pieces(simulation, watch):
    """
    Tell the lengths of the pieces into which a tick of contact is cut, for each that is.
    """
    pieces = contact(simulation).pieces
    in_pieces = pieces.in_pieces

    def watched(h, lengths, advance):
        watch(lengths)
        return in_pieces(h, lengths, advance)

    pieces.in_pieces = watched


def flows(simulation):
    """
    What contact keeps of masses that change.
    """
    return world(simulation).flows


def islands(simulation):
    """
    The islands that sleep.
    """
    return contact(simulation)._sleepers._islands


def groups(simulation):
    """
    How many groups of islands the last tick had.
    """
    return int(contact(simulation).arrays.counts[tick_counts.GROUPS])


def board(simulation):
    """
    What threads tell each other in a tick.
    """
    return contact(simulation).arrays.board


@contextmanager
def helped(simulation, *further):
    """
    Note how many threads may help in each call of the kernel; let further calls be made beside.
    """
    helpers, noted = contact(simulation).ticks._helpers, []
    go = helpers.go

    def noting(leads, help_with, arguments):
        noted.append(len(help_with))
        return go(leads, [*help_with, *further], arguments)

    helpers.go = noting
    try:
        yield noted
    finally:
        del helpers.go


def scratch_of_helpers(simulation):
    """
    What each thread that may help writes into, of calls to come.
    """
    arrays, made = contact(simulation).arrays, []
    world_of_helper = arrays.world_of_helper

    def noting(world):
        made.append(world_of_helper(world))
        return made[-1]

    arrays.world_of_helper = noting
    arrays.version += 1  # all are made anew
    return made


def asleep(simulation):
    """
    Names of the bodies that sleep.
    """
    cores = enumerate(contact(simulation)._sleepers._names)
    bodies = simulation.scene.bodies
    return {bodies[simulation.scene_index(core)].name for core, name in cores if name}


def kept_for_sleep(simulation):
    """
    What contact keeps for sleep, and the arrays that it hands to its kernel for it.
    """
    return contact(simulation)._sleepers, world(simulation).sleep_state


def source_digest():
    """
    Digest of the sources of all kernels.
    """
    return kernels.digest_of_sources()


def kept_piece(kernel, arguments):
    """
    The text that is kept of a function that kernels call with such arguments, and what beside.
    """
    twin, (name, key) = _twin_of(kernel, arguments)
    return PieceFiles(twin._files._folder).load(name, key)  # as another process


def keep_piece(function, folder, arguments, piece, beside):
    """
    Keep another text of a function that kernels call with such arguments.
    """
    kernel = Kernel(function, None, folder, inlined=False, widest=False)
    _, (name, key) = _twin_of(kernel, arguments)
    PieceFiles(folder / 'pieces').save(name, key, piece, beside)


def _twin_of(kernel, arguments):
    from numba import typeof

    twin = kernel._numba_type_.dispatcher
    return twin, twin._place(tuple(map(typeof, arguments)))


def flush(recorder):
    """
    Let a recorder write what it has.
    """
    recorder._writer.flush()


def wanted(words):
    """
    What the verb report understands of its words.
    """
    from rigid_body_sim.verbs import report

    parser = argparse.ArgumentParser()
    report.add_arguments(parser)
    return report._wanted(parser.parse_args(words))


def add_integrator(patch, integrator):
    """
    Let an integrator be known by its name.
    """
    patch.setitem(integrators.INTEGRATORS._found, integrator.name, integrator)


def compile_apart(patch):
    """
    Let each kernel that is not yet in the cache be compiled in a child of the process, and loaded
    from the cache: what compiling takes ends with the child. numba and LLVM would keep it: after a
    first kernel of contact 600 MB, for each further one 60 MB; and two dozen small kernels took a
    fifth longer, for the garbage collector looks through it all.

    patch : pytest's monkeypatch
    """
    if kernels.CACHE is None or sys.platform != 'linux':
        return

    from rigid_body_sim.physics.compile import numba_pipeline

    def in_child(work, *arguments):
        numba_pipeline.make_ready()  # once here, not in each child
        child = os.fork()
        if child == 0:
            gc.disable()  # what is made ends with it
            try:
                work(*arguments)
            finally:
                os._exit(0)  # what went wrong is met again, and told, by the parent
        os.waitpid(child, 0)

    made, compiled = Images.make, numba_pipeline.Kernel.compile

    def make_apart(self, wanted):
        if self.folder is None:
            return made(self, wanted)
        path, _ = wanted.image_file(self.folder)
        with path.with_suffix('.lock').open('w') as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # another worker may be making it
            if self.kept(wanted) is None:
                in_child(made, self, wanted)
        return self.kept(wanted) or made(self, wanted)

    def compile_apart(self, signature):
        key = self._cache._index_key(signature, self.targetctx.codegen())
        if not self._cache._cache_file.holds(key):
            in_child(compiled, self, signature)
        return compiled(self, signature)

    patch.setattr(Images, 'make', make_apart)
    patch.setattr(numba_pipeline.Kernel, 'compile', compile_apart)


def share_kernels(patch):
    """
    Let scenes share a few kernels, which know more than each scene needs: some kinds of forces
    with no element of them; where bodies touch, to bounce, to resist rolling and to turn on arcs,
    rules of pairs, and to sleep, but what is struck at an instant; all pairs of shapes, and where
    only weight acts ground of triangles. Where anything acts beside contact, or a body is moved as
    told, and in all scenes with impacts at their instants, one kernel knows forces that depend on
    velocity, pivots, masses that flow and what is driven; the former also balls off the centre of
    mass.

    None of that changes a bit (`contact/test_same_bits.py`) but two: the inverse inertia of a cube
    or ball is turned in each substep, as that of any body; and where only weight acts, and masses
    flow, bodies are moved as told or impacts are at their instants, its work is added up over
    substeps, not the tick, and what acts is evaluated anew as a tick begins: round-off.

    patch : pytest's monkeypatch
    """
    made, compiled, knows = ContactWorld._compile, step.tick_kernel, ActingElements.__init__
    sleepers_of, driven_by = ContactWorld._make_sleepers, world_arrays.driven_bodies

    def compile_shared(self, scene, evaluate, velocity_dependent):
        known = PAIRS
        if self._events:
            known = EVENT_PAIRS
        elif evaluate is None:
            known = ALL_PAIRS
        self._kinds = tuple(sorted({*known, *self._kinds}))
        if evaluate is not None and not self._events:
            self.arrays.has_ball_off_center = lambda: True
        return _OfAnyTicks(made(self, scene, evaluate, velocity_dependent))

    def tick_kernel(name, **bindings):
        sleeps = bindings['SLEEPING'] or not bindings['EVENTS']
        rules = {'IGNORES': True, 'SLEEPING': sleeps}
        if bindings['COUPLED']:
            rules |= {'DRIVES': True, 'FLOWS': True}
        if bindings['COUPLED'] and not bindings['EVENTS']:
            rules['VELOCITY_DEPENDENT'] = True
        return compiled(name, **{**bindings, **rules})

    def make_sleepers(self, scene, sleeping):
        if sleeping:
            return sleepers_of(self, scene, sleeping)
        count = self._layout.n_moving  # so large that whoever turns, or not, is never slow
        self.arrays.take_sleep_state(make_sleep_state(np.full(count, np.inf), np.arange(count)))
        return None

    def knowing(self, scene, layout):
        knows(self, scene, layout)
        if scene.contact.get('mode', 'none') == 'none':
            if {*self._types} <= USUAL_FORCES:
                _know(self, USUAL_FORCES, scene, layout)
        elif scene.contact['mode'] == EVENT:
            _know_all(self, FORCES_BESIDE_CONTACT if self._types else (), scene, layout)
        elif self.names or _moves_as_told(scene):
            _know_all(self, FORCES_BESIDE_CONTACT, scene, layout)

    def driven_bodies(parts, static):
        driven, rows = driven_by(parts, static)
        return driven._replace(of_bodies=np.zeros(static)), rows

    patch.setattr(world_arrays, 'driven_bodies', driven_bodies)
    patch.setattr(ContactWorld, '_compile', compile_shared)
    patch.setattr(ContactWorld, '_make_sleepers', make_sleepers)
    patch.setattr(ContactWorld, '_angular', _Always(), raising=False)
    patch.setattr(ContactWorld, '_bounces', _Always(), raising=False)
    patch.setattr(step, 'tick_kernel', tick_kernel)
    known = {'turns': True, 'arcs': True}
    patch.setattr(world_module, 'solver', lambda **features: solver(**{**features, **known}))
    patch.setattr(ActingElements, '__init__', knowing)


def points_left_out(simulation):
    """Points of the batches of the last tick that no visit asked after: `far_points`."""
    arrays = simulation._stepper.contact.arrays
    count = int(arrays.counts[tick_counts.BATCHES])
    batches = arrays.batches[: count * batch_record.SIZE].reshape(-1, batch_record.SIZE)
    return int((batches[:, batch_record.POINT_COUNT] - batches[:, batch_record.NEAR_COUNT]).sum())


def most_passes(simulation):
    """
    Bodies of each island that the last substep left to `islands.unsettled`, and the most passes
    that it had: rows.
    """
    record = simulation._stepper.contact.arrays.unsettled.reshape(-1, unsettled_record.SIZE)
    rows = record[record[:, unsettled_record.BODIES] > 0.0]
    return rows[:, [unsettled_record.BODIES, unsettled_record.MOST_PASSES]]


def run_plain(patch):
    """
    Let kernels run as what they are written as: nothing is compiled, the bits are the same
    (`integrators/test_compiled_is_plain.py`), and a tick takes some 200 times as long.

    Kernels of the package remain what they are, for those that are made meanwhile are kept.

    patch : pytest's monkeypatch
    """
    if not kernels.COMPILED:
        return

    def made(function, *, inline, widest=True):
        return Kernel(function, kernels.IMAGES, kernels.CACHE, inlined=inline, widest=widest)

    patch.setattr(kernels, 'COMPILED', False)
    patch.setattr(stepper_module, 'COMPILED', False)
    patch.setattr(kernels, 'kernel', lambda function, **how: made(function, inline=False, **how))
    patch.setattr(kernels, 'inline', lambda function: made(function, inline=True))
    patch.setattr(Kernel, '__call__', lambda self, *arguments: self.py_func(*arguments))
    patch.setattr(
        Kernel, 'prepared', lambda self, _first, last, **_how: behind(self.py_func, last)
    )
    advance = Stepper.advance
    patch.setattr(Stepper, 'advance', lambda *given: _in_a_large_frame(advance, given))
    for module in (held_wrenches, snapshot):
        patch.setattr(module, 'flat', kernels.flat_plain)


# Python keeps frames in chunks of 16 kB. Where the end of one comes to lie among functions that
# are called a million times, each call maps a chunk and gives it back: that takes longer than the
# function. This one has so many variables that its frame has a chunk of 256 kB, of which half is
# left to all that it calls.
_VARIABLES = 17000
_made = {}
exec(
    'def in_a_large_frame(function, arguments):\n'
    '    if function:\n'
    '        return function(*arguments)\n'
    f'    {" = ".join(f"v{i}" for i in range(_VARIABLES))} = None\n',
    _made,
)
_in_a_large_frame = _made['in_a_large_frame']


class _OfAnyTicks:
    """
    A kernel that is told the number of its first tick as one that may be no whole number: of
    forces over time, which may be known and not there, only kernels of scenes with some are told.
    """

    def __init__(self, advance):
        self._advance = advance

    def __call__(self, ticks, tick, *others):
        return self._advance(ticks, float(tick), *others)

    def prepared(self, first, last):
        ticks, tick, *others = first
        call = kernels.prepared(self._advance, (ticks, float(tick), *others), last)
        return lambda ticks, tick, *others: call(ticks, float(tick), *others)


class _Always:
    """What is so, whatever is said of it."""

    def __set__(self, world, value):
        pass

    def __get__(self, world, of=None):
        return True


def _moves_as_told(scene):
    return any(part.motion is not None or any(part.surface_velocity) for part in scene.bodies)


def _know(elements, kinds, scene, layout):
    """
    Let what acts in a scene know more kinds of forces.
    """
    if not elements._types or elements._ranges_of_inertia:
        return
    elements._types = [kind for kind in FORCES if kind in (*elements._types, *kinds)]
    _, elements._ranges, elements._switches = stacked(scene.forces, elements._types, layout)
    elements.set_turning(np.zeros((0, held_body_wrench.COLUMNS)))


def _know_all(elements, kinds, scene, layout):
    """
    Let what acts beside contact know forces, pivots and masses that flow, though there be none.
    """
    elements._always = True
    elements._types = [*elements._types, *kinds]
    elements._flows = _NoRows(elements._flows)
    elements.pivots.count = _Known(elements.pivots.count)
    _know(elements, kinds, scene, layout)
    if not elements._types:
        elements.set_turning(np.zeros((0, held_body_wrench.COLUMNS)))


class _NoRows(list):
    """Rows of which there are some to who asks, though there be none."""

    def __bool__(self):
        return True


class _Known(int):
    """A number that is there to who asks, though it be 0."""

    def __bool__(self):
        return True


def values_by_nodes(text):
    """
    The values of a scene's text by way of PyYAML's tree of nodes.
    """
    return document._constructed(text)


def yaml_by_emitter(mapping):
    """
    The bytes of a mapping as PyYAML's emitter writes them.
    """
    return yaml.dump(
        mapping, Dumper=document._Dumper, sort_keys=False, allow_unicode=True
    ).encode()
