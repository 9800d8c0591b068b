"""The project file of a module's tests."""

import pytest


@pytest.fixture
def drive(request, tmp_path):
    """The text PROJECT of the module, as a file."""
    path = tmp_path / "drive.yaml"
    path.write_text(request.module.PROJECT, encoding="utf-8")
    return path
