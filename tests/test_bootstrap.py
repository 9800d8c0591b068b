"""`tools/bootstrap.py`: what it says where it cannot install, and when it installs again."""

import importlib.util
import sys
from pathlib import Path

import pytest


@pytest.fixture
def bootstrap(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location(
        "bootstrap", Path(__file__).resolve().parent.parent / "tools" / "bootstrap.py"
    )
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name, path in (("VENV", tmp_path), ("STAMP", tmp_path / "stamp"), ("PYTHON", Path(sys.executable))):
        monkeypatch.setattr(module, name, path)
    return module


def test_a_python_without_ensurepip_is_told_in_one_sentence(bootstrap, monkeypatch):
    monkeypatch.setitem(sys.modules, "ensurepip", None)
    with pytest.raises(SystemExit, match=r"^bootstrap: .* has no module ensurepip, .* `apt install python3\.\d+-venv`"):
        bootstrap.create()


@pytest.mark.parametrize("folder", ["lib/python3.12/site-packages", "Lib/site-packages"])
def test_another_installer_that_changes_versions_makes_the_stamp_void(bootstrap, tmp_path, folder):
    packages = tmp_path / folder
    (packages / "numpy-2.1.0.dist-info").mkdir(parents=True)
    bootstrap.STAMP.write_text("\n".join(["key", bootstrap.versions(), "dev", ""]), encoding="utf-8")
    (packages / "__pycache__").mkdir()
    assert bootstrap.installed_extras("key") == {"dev"}
    assert bootstrap.installed_extras("other") is None
    (packages / "numpy-2.1.0.dist-info").rename(packages / "numpy-2.4.0.dist-info")
    assert bootstrap.installed_extras("key") is None
