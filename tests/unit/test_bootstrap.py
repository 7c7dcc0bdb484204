"""The set-up script: what it says and leaves behind when it cannot go on."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[2] / "tools" / "bootstrap.py"


@pytest.fixture
def bootstrap() -> ModuleType:
    spec = importlib.util.spec_from_file_location("bootstrap", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_needs_the_standard_library_only() -> None:
    done = subprocess.run([sys.executable, "-S", "-I", str(SCRIPT), "--help"], capture_output=True, text=True, check=False)
    assert "ModuleNotFoundError" not in done.stderr
    assert "usage" in done.stderr


def test_old_python_is_refused_by_name(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr(bootstrap.sys, "version_info", (3, 9, 2, "final", 0))
    assert bootstrap.main([".venv", "test", "stamp"]) == 1
    said = capsys.readouterr().err
    assert "Python 3.9.2" in said
    assert "3.11 or newer" in said
    assert "make PYTHON=" in said


def test_no_pip_and_no_apt_gives_advice(bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(bootstrap.shutil, "which", lambda name: None)
    with pytest.raises(bootstrap.SetupError, match=r"no apt-get.*apt-get install python3-venv"):
        bootstrap.fetch_debian(tmp_path, "python3-pip-whl")


def test_failed_installation_leaves_no_stamp(bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(bootstrap, "works", lambda venv: True)
    monkeypatch.setattr(bootstrap, "python_of", lambda venv: Path("false"))
    stamp = tmp_path / "stamp"
    assert bootstrap.main([str(tmp_path), "test", str(stamp)]) == 1
    assert not stamp.exists()


def test_environment_of_another_python_is_made_anew(bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    venv = Path(sys.prefix)
    assert bootstrap.works(venv)
    monkeypatch.setattr(bootstrap.sys, "version_info", (3, 99))
    assert not bootstrap.works(venv)


def test_certificates_named_by_the_user_are_enough(
    bootstrap: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(bootstrap, "CERTIFICATES", tmp_path / "missing")
    for name in ("PIP_CERT", "REQUESTS_CA_BUNDLE"):
        monkeypatch.delenv(name, raising=False)
    assert not bootstrap.has_certificates(["false"])
    monkeypatch.setenv("PIP_CERT", "some.crt")
    assert bootstrap.has_certificates(["false"])
