# Copyright 2026 rigid_body_sim maintainers
# SPDX-License-Identifier: Apache-2.0
"""
The message packages that tests make for themselves go over the wire as the published ones do.
"""

import pytest

from ..message_packages import hashes_of, importable, provide

# Of the published definitions: tf2_msgs of Jazzy, simulation_interfaces 1.5.1. The hash of a
# service or an action covers all messages in it.
PUBLISHED = """
tf2_msgs msg/TFMessage
    RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087
simulation_interfaces action/SimulateSteps
    RIHS01_f0837c898e1219cd73bf4c041feab41e8c533e8e1057e982744dba7b093467eb
simulation_interfaces srv/GetEntities
    RIHS01_cb90004c48cd50f37732fb008e22c34c261dd680a723bf0f85d8437ea4498bf7
simulation_interfaces srv/GetEntitiesStates
    RIHS01_0a76170d0c1c90e1eaf805cfab78ea801d1f82df309a28c1f0fae4b570f19754
simulation_interfaces srv/GetEntityBounds
    RIHS01_17be8d36231178a5eed0de0344b55c19975581627a9aec30a4fee9926a35deed
simulation_interfaces srv/GetEntityInfo
    RIHS01_953b7ab6bfc35063f5c9a72463c6ce489baa10249a7fa510926d342a34b0d29e
simulation_interfaces srv/GetEntityState
    RIHS01_749c91f2a2353d98367b64f2995a0f5842ce92a08ec1ffb3e185540a91557fb5
simulation_interfaces srv/GetNamedPoseBounds
    RIHS01_59fa8dd2c68ba6771160cc66a628ac99fa95e2748fa0a43c2cc62a2e5f3f6fdc
simulation_interfaces srv/GetNamedPoses
    RIHS01_c3d12ab920115bfd4733f6d20516adc3968fb438538540997c37e200e02b04e3
simulation_interfaces srv/GetSimulationState
    RIHS01_3362dcebee4b1afebbf9c4beee5c79c1455385aded62092a892d61fde8644f30
simulation_interfaces srv/GetSimulatorFeatures
    RIHS01_abb9439c8cf196722a469fb6c68b44b484f198c2a1356ac38849a29c2a20a794
simulation_interfaces srv/ResetSimulation
    RIHS01_4ce285d7ff9b8ac70dcc95161f32bf54c05a6f4b13427990e41ab40c36c39646
simulation_interfaces srv/SetEntityState
    RIHS01_ca210e7d2b66629ae133c8e1edf5246e618106d75c78ed0556c0e7a33c59ee5e
simulation_interfaces srv/SetSimulationState
    RIHS01_a868b916dce49974f637ba252141258c4b07b0c06858b88af560e3eb6bfbcb30
simulation_interfaces srv/StepSimulation
    RIHS01_913fe0653690ce6bf8f09f316e6a626747012e9fca31e26719910d417aa8565c
"""


@pytest.mark.parametrize('package', ['tf2_msgs', 'simulation_interfaces'])
def test_types_made_for_tests_have_the_published_type_hashes(package):
    with importable(package):
        if provide(package) is None:
            pytest.skip(f'{package} is installed: no need to make it')
        made = hashes_of(package)
    words = iter(PUBLISHED.split())
    expected = {
        f'{owner}/{name}': text for owner, name, text in zip(words, words, words, strict=True)
    }
    expected = {name: text for name, text in expected.items() if name.startswith(package)}
    assert expected
    assert expected.items() <= made.items()
