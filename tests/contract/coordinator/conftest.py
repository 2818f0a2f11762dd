"""The coordinator's app over a fake world in fake time."""

import pytest

from support.coordinator_mesh import OpenMesh, opened_mesh


@pytest.fixture
def open_mesh() -> OpenMesh:
    return opened_mesh
