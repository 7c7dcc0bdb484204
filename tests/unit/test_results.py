"""The result file: written while a run goes on, read by h5py and xarray, valid whatever happens to the run."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
import textwrap
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
import stand_in
import xarray

import lamella as lm
from lamella.dofs import Signal
from lamella.errors import ModelError, ResultFileError
from lamella.io.modes import mode_frames, read_modes, write_modes
from lamella.io.results import ResultWriter, read_result, write_result
from lamella.result import Cause, Outcome, Recorder, Result, Statistics
from lamella.state import State
from lamella.viz.fields import SurfaceSampler
from lamella.viz.scene import picture

N_Q = 6
TEXT = '{"plates": {"wing": {"size": [1.5, 2.0]}}}'
SIGNALS = (
    Signal("tip.position", "m", ("x", "y", "z"), lambda state: state.q[:3], "position of the tip"),
    Signal("energy.kinetic", "J", (), lambda state: 0.5 * float(state.v @ state.v), "kinetic energy"),
    Signal("root.moment", "N m", ("along", "across"), lambda state: state.q[3:5]),
)


def state_at(t: float) -> State:
    """A state whose numbers differ in every component and at every time."""
    q = np.arange(N_Q) + t
    return State(t, q, 2.0 * q, np.zeros(N_Q), np.empty(0), np.zeros(N_Q))


def run(sinks: tuple[ResultWriter, ...] = (), steps: int = 40, axis: str = "time") -> Recorder:
    recorder = Recorder(SIGNALS, axis, 0.0, 1.0, frames=10, sinks=sinks)
    for t in np.linspace(0.0, 1.0, steps + 1):
        recorder.sample(float(t), state_at(float(t)))
    return recorder


def test_a_sample_keeps_all_components_side_by_side() -> None:
    recorder = run(steps=2)
    samples, states = recorder.samples(), [state_at(t) for t in (0.0, 0.5, 1.0)]
    assert [signal.name for signal in SIGNALS] == list(samples)
    for signal in SIGNALS:
        expected = np.reshape([signal.evaluate(state) for state in states], (3, max(len(signal.labels), 1)))
        assert np.array_equal(samples[signal.name], expected)
    assert [part.shape for part in Recorder(SIGNALS, "time", 0.0, 1.0).samples().values()] == [(0, 3), (0, 1), (0, 2)]


def small_system() -> lm.System:
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=0.01)
    system.add(lm.Plate("wing", size=(1.5, 2.0), mesh=(2, 1), laminate=sheet))
    return system


def result_of(recorder: Recorder) -> Result:
    model = SimpleNamespace(imperfection=None, description=small_system())
    statistics = Statistics(steps=40, newton_iterations=90, seconds_run=0.25)
    return Result(model, recorder, state_at(1.0), Outcome(Cause.COMPLETED, 1.0, 1.0), statistics)  # type: ignore[arg-type]


@pytest.fixture
def written(tmp_path: Path) -> Path:
    """A file written by a run that ended."""
    path = tmp_path / "run.h5"
    writer = ResultWriter(path, SIGNALS, "time", N_Q, model_text=TEXT, title="a wing", target=1.0)
    run((writer,))
    writer.close(Outcome(Cause.COMPLETED, 1.0, 1.0), Statistics(steps=40, seconds_run=0.25))
    return path


def test_h5py_reads_values_units_and_labels(written: Path) -> None:
    with h5py.File(written) as file:
        tip = file["signals/tip.position"]
        assert tip.shape == (41, 3)
        assert tip.maxshape == (None, 3)
        np.testing.assert_array_equal(tip[4], np.arange(3) + 0.1)
        assert (tip.attrs["units"], tip.attrs["long_name"]) == ("m", "position of the tip")
        np.testing.assert_array_equal(tip.dims[0]["time"][:3], [0.0, 0.025, 0.05])
        assert list(tip.dims[1][0].asstr()) == ["x", "y", "z"]
        assert file["signals/energy.kinetic"].shape == (41,)
        assert file["frames/q"].shape == (11, N_Q)
        np.testing.assert_array_equal(file["frames/v"][3], 2.0 * file["frames/q"][3])
        assert file["statistics/steps"][()] == 40
        assert file["statistics/seconds_run"].attrs["units"] == "s"


def test_root_attributes_say_what_and_with_what(written: Path) -> None:
    with h5py.File(written) as file:
        attributes = dict(file.attrs)
    assert attributes["model"] == TEXT
    assert attributes["title"] == "a wing"
    assert attributes["numpy_version"] == np.__version__
    assert {"lamella_version", "scipy_version", "numba_version", "python_version", "created"} <= set(attributes)
    assert (attributes["outcome"], attributes["reached"], attributes["target"]) == ("completed", 1.0, 1.0)


def test_xarray_reads_groups(written: Path) -> None:
    with xarray.open_dataset(written, engine="h5netcdf", group="signals") as signals:
        assert signals["tip.position"].dims == ("time", "component")
        assert signals.time.dtype == np.float64  # seconds stay numbers, they are not decoded as a calendar time
        assert signals["tip.position"].sel(component="z", time=0.5).item() == 2.5
        assert signals["tip.position"].attrs["units"] == "m"
        assert list(signals["root.moment"].coords["component_along_across"].values) == ["along", "across"]
    with xarray.open_dataset(written, engine="h5netcdf", group="frames") as frames:
        assert frames.q.dims == ("time", "coordinate")
        assert frames.q.shape == (11, N_Q)


def test_read_result_has_the_interface_of_a_result(written: Path) -> None:
    memory, stored = result_of(run()), read_result(written)
    assert list(stored.signals) == list(memory.signals)
    for name in memory.signals:
        xarray.testing.assert_identical(stored.history(name), memory.history(name))
    np.testing.assert_array_equal(stored.frame_at, memory.frame_at)
    np.testing.assert_array_equal(stored.frame_q, memory.frame_q)
    assert stored.outcome == Outcome(Cause.COMPLETED, 1.0, 1.0)
    assert stored.statistics.steps == 40
    assert (stored.model_text, stored.title) == (TEXT, "a wing")
    np.testing.assert_array_equal(stored.final.v, 2.0 * memory.frame_q[-1])


@pytest.mark.parametrize("axis", ["time", "load_factor", "path"])
def test_saved_result_reads_back(tmp_path: Path, axis: str) -> None:
    memory = result_of(run(axis=axis))
    path = memory.save(tmp_path / "saved.h5")
    stored = read_result(path)
    assert stored.axis == axis
    xarray.testing.assert_identical(stored["tip.position"], memory["tip.position"])
    assert "size: [1.5, 2.0]" in stored.model_text
    assert stored.model.plates[0].name == "wing"
    assert stored.model.n_q == 6 * 12
    again = write_result(stored, tmp_path / "again.h5")
    assert read_result(again).model_text == stored.model_text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again.h5", "saved.h5"]  # no partial file stays


def test_running_file_is_readable_and_says_how_far_it_got(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    writer = ResultWriter(path, SIGNALS, "time", N_Q, target=1.0)
    for t in (0.0, 0.1, 0.2):
        writer.sample(t, [state_at(t).q[:3], np.array([1.0]), np.zeros(2)])
    writer.flush()
    stored = read_result(path)
    assert stored.outcome.cause is Cause.INTERRUPTED
    assert (stored.outcome.reached, stored.outcome.target) == (0.2, 1.0)
    assert len(stored.at) == 3
    writer.close(Outcome(Cause.INTERRUPTED, 0.2, 1.0), Statistics())
    assert str(read_result(path).outcome) == "stopped at 0.2 of 1: interrupted by the user"


def child(tmp_path: Path, code: str) -> subprocess.CompletedProcess[str]:
    """Run ``code`` in a process of its own, with this test's definitions."""
    header = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\nfrom test_results import *\n"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
    command = [sys.executable, "-c", header + textwrap.dedent(code)]
    return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, env=environment, check=False)


def test_killed_run_leaves_a_valid_file(tmp_path: Path) -> None:
    done = child(
        tmp_path,
        """
        import os, signal
        writer = ResultWriter("run.h5", SIGNALS, "time", N_Q, target=1.0, flush_seconds=0.0)
        run((writer,), steps=400)
        os.kill(os.getpid(), signal.SIGKILL)
        """,
    )
    assert done.returncode == -9, done.stderr
    stored = read_result(tmp_path / "run.h5")
    assert len(stored.at) == 401
    assert stored.outcome.reached == 1.0
    assert "killed" in stored.outcome.detail


@pytest.mark.skipif(sys.platform == "win32", reason="file size limits are a POSIX feature")
def test_file_that_cannot_grow_keeps_what_was_flushed(tmp_path: Path) -> None:
    done = child(
        tmp_path,
        """
        import resource
        writer = ResultWriter("run.h5", SIGNALS, "time", N_Q, target=1.0, flush_seconds=0.01)
        resource.setrlimit(resource.RLIMIT_FSIZE, (700_000, 700_000))
        try:
            run((writer,), steps=8000)
        except ResultFileError as error:
            print("refused:", error)
            writer.close(Outcome(Cause.WRITE_FAILED, 0.5, 1.0), Statistics())
        """,
    )
    assert done.returncode == 0, done.stderr
    assert "refused: result file 'run.h5' cannot be written beyond time" in done.stdout
    stored = read_result(tmp_path / "run.h5")
    assert len(stored.at) > 100
    np.testing.assert_allclose(stored.history("tip.position")[:, 0], stored.at, rtol=0, atol=0)


def test_full_disk_is_noticed_before_the_file_is_harmed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    writer = ResultWriter(tmp_path / "run.h5", SIGNALS, "time", N_Q, target=1.0)
    run((writer,), steps=5)
    writer.flush()

    def full(descriptor: int, offset: int, size: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr("lamella.io.result_layout.os.posix_fallocate", full, raising=False)
        writer.sample(1.5, [np.zeros(3), np.zeros(1), np.zeros(2)])
        with pytest.raises(ResultFileError, match=r"cannot be written beyond time 1\.5.*No space left.*another folder"):
            writer.flush()
    writer.close(Outcome(Cause.WRITE_FAILED, 1.0, 2.0, "disk full"), Statistics())
    stored = read_result(tmp_path / "run.h5")
    assert stored.outcome.cause is Cause.WRITE_FAILED
    assert len(stored.at) == 6


def test_reserved_room_is_given_back(written: Path) -> None:
    assert written.stat().st_size < 100_000  # 41 samples and 11 frames in whole chunks; the reserve alone is 256 kB


def test_existing_result_is_kept_unless_asked(written: Path) -> None:
    with pytest.raises(ResultFileError, match=r"run\.h5' exists already; choose another name or ask to overwrite"):
        ResultWriter(written, SIGNALS, "time", N_Q)
    assert len(read_result(written).at) == 41
    ResultWriter(written, SIGNALS, "time", N_Q, overwrite=True).close(Outcome(Cause.COMPLETED, 0, 0), Statistics())
    assert len(read_result(written).at) == 0


def test_other_files_are_never_replaced(tmp_path: Path) -> None:
    model = tmp_path / "model.yaml"
    model.write_text("title: mine")
    with pytest.raises(ResultFileError, match="is not a result file, so it is not replaced"):
        ResultWriter(model, SIGNALS, "time", N_Q, overwrite=True)
    with pytest.raises(ResultFileError, match="is not a result file, so it is not replaced"):
        result_of(run()).save(model)
    assert model.read_text() == "title: mine"


@pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs a folder nobody may write to")
def test_devices_are_never_replaced(tmp_path: Path, bent: Result) -> None:
    pipe = tmp_path / "pipe.h5"
    os.mkfifo(pipe)
    with pytest.raises(ResultFileError, match=r"result file '.*pipe\.h5' is a device; accepted is the name of a file"):
        bent.save(pipe)
    assert pipe.is_fifo()


def test_folder_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match=r"/proc/run\.h5' cannot be created.*accepted is a file in a writable folder"):
        ResultWriter("/proc/run.h5", SIGNALS, "time", N_Q)
    with pytest.raises(ResultFileError, match=r"folder '.*nowhere' does not exist"):
        result_of(run()).save(tmp_path / "nowhere" / "run.h5")
    with pytest.raises(ResultFileError, match="is a folder"):
        result_of(run()).save(tmp_path)


def test_what_is_not_a_result_file(tmp_path: Path, written: Path) -> None:
    with pytest.raises(ResultFileError, match=r"none\.h5' does not exist"):
        read_result(tmp_path / "none.h5")
    text = tmp_path / "text.h5"
    text.write_text("hello")
    with pytest.raises(ResultFileError, match="is not a result file; accepted is"):
        read_result(text)
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1.0
    with pytest.raises(ResultFileError, match="is not a result file; accepted is"):
        read_result(tmp_path / "other.h5")
    (tmp_path / "cut.h5").write_bytes(written.read_bytes()[:3000])
    with pytest.raises(ResultFileError, match=r"cut\.h5' is damaged or cannot be read"):
        read_result(tmp_path / "cut.h5")
    with h5py.File(written, "r+") as file:
        file.attrs["format_version"] = "9.0"
    with pytest.raises(ResultFileError, match=r"has format 9\.0; accepted is 1"):
        read_result(written)


def test_altered_files_are_read_or_refused_with_words(tmp_path: Path, written: Path) -> None:
    """Some bytes are overwritten, or the end is missing."""
    whole, path, random = written.read_bytes(), tmp_path / "altered.h5", np.random.default_rng(11)
    refused = 0
    for count in [0, 1, 4, 64] * 30:
        altered, at = bytearray(whole), int(random.integers(len(whole) - 64))
        altered[at : at + count] = random.bytes(count)
        path.write_bytes(altered if count else altered[:at])
        try:
            read_result(path)
        except ResultFileError:
            refused += 1
    assert refused > 30  # the files that are cut, at the least


def test_result_without_model_says_so(tmp_path: Path) -> None:
    writer = ResultWriter(tmp_path / "run.h5", SIGNALS, "time", N_Q)
    writer.close(Outcome(Cause.COMPLETED, 0, 0), Statistics())
    stored = read_result(tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="holds no model"):
        _ = stored.model
    with pytest.raises(ResultFileError, match="holds no frame"):
        _ = stored.final


@pytest.fixture(scope="module")
def bent() -> Result:
    """A strip bent by its tip load in two load steps."""
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=0.002)
    strip = system.add(lm.Plate("strip", size=(1.0, 0.1), mesh=(2, 1), laminate=sheet))
    system.add(lm.Clamp("root", strip.edge("x-")))
    system.add(lm.PointForce("load", strip.marker("tip", 1.0, 0.05), (0, 0, -0.5)))
    return lm.equilibrium(system, steps=2)


def test_saved_solution_brings_back_its_model_fields_and_pictures(tmp_path: Path, bent: Result) -> None:
    stored = read_result(bent.save(tmp_path / "bent.h5"))
    assert [item.name for item in stored.model.description.declarations] == ["strip", "root", "load"]
    assert list(stored.signals) == list(bent.signals)
    for name in bent.signals:
        xarray.testing.assert_identical(stored.history(name), bent.history(name))
    np.testing.assert_array_equal(stored["load_factor"], 1.0)
    np.testing.assert_array_equal(stored.model.q0, bent.model.q0)
    for frame in (0, 2, None):
        old, new = bent.plate("strip", frame), stored.plate("strip", frame)
        for name in ("r", "n", "strains"):
            np.testing.assert_array_equal(getattr(new, name), getattr(old, name))
    shown = [picture(each, tmp_path / f"{k}.png", renderer="matplotlib", width=480) for k, each in enumerate((bent, stored))]
    assert shown[0].read_bytes() == shown[1].read_bytes()
    with xarray.open_dataset(tmp_path / "bent.h5", engine="h5netcdf", group="signals") as signals:
        np.testing.assert_array_equal(signals.load_factor, [0.0, 0.5, 1.0])


def test_writer_refuses_samples_of_other_signals(tmp_path: Path) -> None:
    writer = ResultWriter(tmp_path / "run.h5", SIGNALS, "time", N_Q)
    with pytest.raises(AssertionError, match="2 values for 3 signals"):
        writer.sample(0.0, [np.zeros(3), np.zeros(1)])
    writer.close(Outcome(Cause.COMPLETED, 0, 0), Statistics())


def test_modes_are_stored_and_read_back(tmp_path: Path, bent: Result) -> None:
    found = lm.modes(bent.model, 4, state=bent.final)
    path = write_modes(found, tmp_path / "modes.h5", title="strip")
    again = read_modes(path)
    for name in ("frequencies", "shapes", "state"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    np.testing.assert_array_equal(again.model.q0, found.model.q0)
    with xarray.open_dataset(path, engine="h5netcdf") as stored:
        assert stored.shapes.dims == ("mode", "coordinate")
        assert stored.frequency.sel(mode=1).item() == found.frequencies[0]
        assert stored.frequency.attrs["units"] == "Hz"
        assert stored.attrs["title"] == "strip"
    with pytest.raises(ResultFileError, match="is not a result file"):
        read_result(path)
    with pytest.raises(ResultFileError, match="is not a file of modes"):
        read_modes(bent.save(tmp_path / "bent.h5"))
    with pytest.raises(ResultFileError, match="does not exist; create it or choose another"):
        write_modes(found, tmp_path / "nowhere" / "modes.h5")


def test_frames_of_modes_show_the_shape_about_its_state(bent: Result) -> None:
    found = lm.modes(bent.model, 3, state=bent.final)
    frames = mode_frames(found, 0.2, count=2)
    assert frames.axis == "mode"
    np.testing.assert_array_equal(frames.frame_at, [1, 2])
    np.testing.assert_array_equal(frames.history("frequency"), found.frequencies[:2])
    shot = SurfaceSampler(frames, 1).at(1)[0]  # grid points are the nodes
    np.testing.assert_array_equal(shot.reference.r, bent.plate("strip", per_element=1).r)
    assert np.linalg.norm(shot.displacement, axis=-1).max() == pytest.approx(0.2, rel=1e-12)


def test_run_of_rigid_bodies_is_written_and_read_back(tmp_path: Path) -> None:
    done = stand_in.pendulum()
    path = done.save(tmp_path / "pendulum.h5")
    read = read_result(path)
    elements = tuple(f"{i}{j}" for i in "xyz" for j in "xyz")
    for name in ("arm.rotation", "arm.quaternion", "arm.euler", "pin.angle", "pin.force_local"):
        np.testing.assert_array_equal(read.history(name).values, done.history(name).values)
        assert read.signals[name].labels == done.signals[name].labels
    assert read.signals["arm.rotation"].labels == elements
    turn = read.history("arm.rotation").values.reshape(-1, 3, 3)
    np.testing.assert_allclose(turn @ turn.transpose(0, 2, 1), np.broadcast_to(np.eye(3), turn.shape), atol=1e-9)
    with xarray.open_dataset(path, engine="h5netcdf", group="signals") as signals:
        rotation = signals["arm.rotation"]
        assert rotation.shape == (len(done.at), 9)
        assert tuple(rotation.coords[rotation.dims[1]].values) == elements
    assert [body.name for body in read.model.rigid_bodies] == ["arm", "ball", "weight"]
    assert not read.model.plates
    np.testing.assert_array_equal(read.frame_q, done.frame_q)
    vertices = [result.model.rigid_bodies[1].surface(result.frame_q[-1])[0] for result in (read, done)]
    np.testing.assert_array_equal(*vertices)


@pytest.mark.parametrize("name", ["", "left/right", "a\0"])
def test_names_that_no_file_can_hold_are_refused(name: str) -> None:
    system, sheet = lm.System(), lm.Laminate(lm.Isotropic(7e10, 0.3, 2700), thickness=1e-3)
    plate = system.add(lm.Plate("plate", (1, 1), (1, 1), sheet))
    system.add(lm.Clamp(name, plate.edge("x-")))
    with pytest.raises(ModelError, match="accepted are names that are not empty and hold no '/'"):
        system.compile()
    free = lm.System()
    free.add(lm.Plate("plate", (1, 1), (1, 1), sheet)).marker(name, 0.5, 0.5)
    with pytest.raises(ModelError, match="cannot be recorded"):
        free.compile()


def test_result_of_names_that_no_model_file_can_hold_says_so(tmp_path: Path) -> None:
    system, sheet = lm.System(), lm.Laminate(lm.Isotropic(7e10, 0.3, 2700), thickness=1e-3)
    plate = system.add(lm.Plate("my plate", (1, 1), (1, 1), sheet))
    system.add(lm.Clamp("root", plate.edge("x-")))
    lm.equilibrium(system).save(tmp_path / "run.h5")
    with pytest.raises(ResultFileError, match="Plate 'my plate': a model file cannot hold this name; accepted are letters"):
        lm.read_result(tmp_path / "run.h5").plate("my plate")
