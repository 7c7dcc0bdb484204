"""Make the project's environment with nothing but Python's standard library.

    python3 tools/bootstrap.py .venv EXTRAS STAMP

creates the virtual environment ``.venv``, installs lamella into it (editable, with the comma-separated extras) and
writes the file STAMP, by which ``make`` knows that this is done. Debian's ``python3`` alone has neither pip nor
ensurepip; pip then comes, in this order, from ensurepip, from a pip outside of the environment, from the wheel that a
distribution keeps on disk, or from Debian's package ``python3-pip-whl``, which apt can fetch and verify without root
and which is unpacked here, not installed. Debian's pip trusts the certificates of the package ``ca-certificates``;
where that is missing too, it is fetched in the same way.
"""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

OLDEST = (3, 11)
ROOT = Path(__file__).resolve().parent.parent
WHEELS = Path("/usr/share/python-wheels")
CERTIFICATES = Path("/etc/ssl/certs/ca-certificates.crt")
ADVICE = "Install pip yourself and try again; on Debian: apt-get install python3-venv ca-certificates"


class SetupError(Exception):
    """The environment cannot be made; the message says why and what to do."""


def say(text: str) -> None:
    """Print one line of progress at once."""
    print("[set-up] " + text, flush=True)


def run(command: list[str], problem: str, advice: str) -> None:
    """Run a command, its output going to the terminal."""
    if subprocess.run(command, check=False).returncode != 0:
        raise SetupError(f"{problem} (the messages above say why). {advice}")


def check_python() -> None:
    """Refuse a Python that lamella does not support."""
    if sys.version_info < OLDEST:
        found = ".".join(str(part) for part in sys.version_info[:3])
        wanted = ".".join(str(part) for part in OLDEST)
        raise SetupError(
            f"Python {found} ({sys.executable}) is too old: lamella needs {wanted} or newer. "
            "Name a newer one, for example: make PYTHON=python3.12 test"
        )


def has(module: str) -> bool:
    """Tell whether the running Python has a module."""
    return importlib.util.find_spec(module) is not None


def python_of(venv: Path) -> Path:
    """The interpreter of a virtual environment."""
    return venv / "bin" / "python"


def works(venv: Path) -> bool:
    """Tell whether the environment exists, its Python is the running one's version, and it has pip."""
    if not python_of(venv).exists():
        return False
    check = f"import sys, pip; sys.exit(sys.version_info[:2] != {sys.version_info[:2]!r})"
    return subprocess.run([str(python_of(venv)), "-c", check], capture_output=True, check=False).returncode == 0


def make_venv(venv: Path) -> None:
    """Create the environment, with pip in it."""
    say(f"creating {venv} with Python {sys.version.split()[0]}")
    shutil.rmtree(venv, ignore_errors=True)
    command = [sys.executable, "-m", "venv", str(venv)]
    if has("ensurepip"):
        run(command, "python3 -m venv failed", "On Debian: apt-get install python3-venv")
        return
    run([*command, "--without-pip"], "python3 -m venv --without-pip failed", "On Debian: apt-get install python3-venv")
    if has("pip"):
        install_pip(venv, [sys.executable, "-m", "pip", "--python", str(python_of(venv))], [])
        return
    with tempfile.TemporaryDirectory() as folder:
        wheel = find_wheel(WHEELS) or fetch_wheel(Path(folder))
        say(f"installing pip from {wheel.name}")
        pip = [str(python_of(venv)), str(wheel / "pip")]
        install_pip(venv, pip, ["--no-index", "--find-links", str(wheel.parent)])
        pip = [str(python_of(venv)), "-m", "pip"]
        if not has_certificates(pip):
            os.environ["PIP_CERT"] = str(fetch_certificates(Path(folder), venv))
            install_pip(venv, pip, ["--upgrade"])  # PyPI's pip brings certificates of its own, for the set-ups to come


def install_pip(venv: Path, pip: list[str], options: list[str]) -> None:
    """Let a pip from outside install pip into the environment."""
    run(
        [*pip, "install", "--quiet", "--disable-pip-version-check", *options, "pip"],
        f"pip could not be installed into {venv}",
        "Remove the folder and try again, or: apt-get install python3-venv",
    )


def find_wheel(folder: Path) -> Path | None:
    """The newest pip wheel of a folder, if there is one."""
    wheels = sorted(folder.glob("pip-*.whl"))
    return wheels[-1] if wheels else None


def fetch_wheel(folder: Path) -> Path:
    """Fetch Debian's own pip wheel."""
    say("this Python has no pip: fetching Debian's package python3-pip-whl (1.7 MB)")
    wheel = find_wheel(fetch_debian(folder, "python3-pip-whl") / WHEELS.relative_to("/"))
    if wheel is None:
        raise SetupError(f"Debian's package python3-pip-whl holds no pip wheel. {ADVICE}")
    return wheel


def has_certificates(pip: list[str]) -> bool:
    """Tell whether Debian's pip finds certificates: those of the machine or those that the user names."""
    if CERTIFICATES.exists() or "PIP_CERT" in os.environ or "REQUESTS_CA_BUNDLE" in os.environ:
        return True
    return subprocess.run([*pip, "config", "get", "global.cert"], capture_output=True, check=False).returncode == 0


def fetch_certificates(folder: Path, venv: Path) -> Path:
    """Fetch Debian's certificates and write them to one file in the environment."""
    say("this machine has no certificates: fetching Debian's package ca-certificates (0.2 MB)")
    certificates = sorted((fetch_debian(folder, "ca-certificates") / "usr/share/ca-certificates").rglob("*.crt"))
    bundle = venv / "ca-certificates.crt"
    bundle.write_text("".join(path.read_text() for path in certificates))
    return bundle


def fetch_debian(folder: Path, package: str) -> Path:
    """Fetch a package with apt, which verifies its signature, and unpack it; neither root nor an installation is needed."""
    if not shutil.which("apt-get") or not shutil.which("dpkg-deb"):
        raise SetupError(f"there is no apt-get to fetch {package} with. {ADVICE}")
    state = folder / "apt"
    archive = download(folder, package, apt_options(state) if state.exists() else [])
    if archive is None and not state.exists():  # the machine's package lists are missing or old
        update(state)
        archive = download(folder, package, apt_options(state))
    if archive is None:
        raise SetupError(f"apt could not download {package}. Is the network reachable? {ADVICE}")
    unpacked = folder / package
    run(["dpkg-deb", "-x", str(archive), str(unpacked)], f"{archive.name} could not be unpacked", ADVICE)
    return unpacked


def download(folder: Path, package: str, options: list[str]) -> Path | None:
    """Download a package into a folder; None when apt fails."""
    command = ["apt-get", "--quiet=2", *options, "download", package]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    archives = sorted(folder.glob(f"{package}_*.deb"))
    if done.returncode == 0 and archives:
        return archives[-1]
    if options:
        print(done.stderr, file=sys.stderr)
    return None


def apt_options(state: Path) -> list[str]:
    """Options that let apt keep its package lists in a folder of ours."""
    options = ["-o", f"Dir::State::Lists={state / 'lists'}", "-o", f"Dir::Cache={state / 'cache'}"]
    return [*options, "-o", "APT::Sandbox::User="]  # the folder is readable by us alone


def update(state: Path) -> None:
    """Fetch Debian's package lists into a folder of ours."""
    say("reading Debian's package lists")
    for part in ("lists/partial", "cache/archives/partial"):
        (state / part).mkdir(parents=True)
    subprocess.run(["apt-get", "--quiet=2", *apt_options(state), "update"], check=False)  # a failure shows in the download


def install(venv: Path, extras: str) -> None:
    """Install lamella and its libraries."""
    what = f"lamella[{extras}]" if extras else "lamella"
    say(f"installing {what} and the libraries it needs; this takes a few minutes the first time")
    command = [str(python_of(venv)), "-m", "pip", "install", "--disable-pip-version-check", "--quiet", "--editable"]
    run([*command, f"{ROOT}[{extras}]" if extras else str(ROOT)], "installing the libraries failed", "Is PyPI reachable?")


def main(arguments: list[str]) -> int:
    """Run the set-up; the exit code is 1 when it fails, 2 when it is called in a wrong way."""
    if len(arguments) != 3:
        print("usage: python3 tools/bootstrap.py VENV EXTRAS STAMP", file=sys.stderr)
        return 2
    venv, extras, stamp = Path(arguments[0]), arguments[1], Path(arguments[2])
    start = time.monotonic()
    os.environ.pop("PYTHONPATH", None)  # the environment shall not see libraries of another one
    try:
        check_python()
        if not works(venv):
            make_venv(venv)
        install(venv, extras)
    except SetupError as error:
        print(f"\nset-up failed: {error}", file=sys.stderr)
        return 1
    stamp.touch()
    say(f"ready after {time.monotonic() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
