"""Parameter studies as a user runs them: files, workers that are killed, interruptions, clusters, tables and pages."""

from __future__ import annotations

import csv
import json
import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lamella as lm
import lamella.sweep.cluster
import lamella.sweep.local
import lamella.sweep.processes
import lamella.sweep.run
from lamella.errors import ResultFileError, WorkerError
from lamella.sweep.local import LocalWorkers
from lamella.sweep.processes import Spawns
from lamella.sweep.store import Store
from lamella.sweep.study import read_study
from lamella.sweep.table import StudyResult
from lamella.sweep.task import Row, Task, run_task

STUDY = """\
study: 1
title: Strip
model: strip.yaml
parameters:
  thickness: {path: system.strip.laminate.thickness, range: [1 mm, 3 mm], count: 3}
  load: {path: 'system.load.force[2]', values: [-0.1 N, -0.2 N]}
design: {kind: grid}
outputs:
  deflection: {signal: tip.position, component: z, statistic: min}
"""
DEADLINE = 300.0

Command = Callable[..., subprocess.CompletedProcess[str]]


class Inline:
    """Workers that run everything in this process."""

    seen: list[int]

    def __init__(self, count: int, say: Callable[[str], None]) -> None:
        self.count = count

    def __enter__(self) -> Inline:
        return self

    def __exit__(self, *_: Any) -> None:
        pass

    def run(self, tasks: Sequence[Task]) -> Generator[Row, None, None]:
        for task in tasks:
            Inline.seen.append(task.number)
            yield run_task(task)


@pytest.fixture
def inline(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Runs are done in this process; returns the numbers of those done."""
    Inline.seen = []
    monkeypatch.setattr(lamella.sweep.run, "LocalWorkers", Inline)
    return Inline.seen


@pytest.fixture
def study(model: Path, tmp_path: Path) -> Path:
    path = tmp_path / "study.yaml"
    path.write_text(STUDY)
    return path


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "table.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def kept(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in (folder / "runs").glob("[0-9]*.json")}  # none that is being written


def wait_for_runs(folder: Path, number: int) -> None:
    end = time.monotonic() + DEADLINE
    while len(kept(folder)) < number:
        assert time.monotonic() < end
        time.sleep(0.02)


def test_a_study_writes_table_pictures_and_page(here: Command, study: Path, tmp_path: Path, inline: list[int]) -> None:
    done = here("study", study, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "6 runs, 0 failed" in done.stdout
    rows = table(tmp_path / "out")
    assert [(row["run"], row["thickness [mm]"], row["load [N]"]) for row in rows[:3]] == [
        ("1", "1.0", "-0.1"),
        ("2", "1.0", "-0.2"),
        ("3", "2.0", "-0.1"),
    ]
    z = np.array([float(row["deflection [m]"]) for row in rows]).reshape(3, 2)
    assert (z < 0.0).all()
    np.testing.assert_allclose(z[:, 1] / z[:, 0], 2.0, rtol=0.05)  # twice the load, and nearly linear
    import pyarrow.parquet

    columns = pyarrow.parquet.read_table(tmp_path / "out" / "table.parquet").to_pydict()
    assert columns["deflection [m]"] == z.ravel().tolist()
    assert (tmp_path / "out" / "pictures" / "map-deflection.png").stat().st_size > 1000
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "6 runs, none failed" in page
    assert page.count("data:image/png") == 1


def test_other_designs_have_their_pictures_and_sensitivities(study: Path, tmp_path: Path, inline: list[int]) -> None:
    def run(name: str, **changes: Any) -> StudyResult:
        given: dict[str, Any] = {"model": str(tmp_path / "strip.yaml"), "design": lm.LatinHypercubeDesign(6, seed=1)}
        outputs = {"z": lm.SignalOutput("tip.position", component="norm", start=0.005, end=0.015, statistic="mean")}
        return lm.run_parameter_study(lm.ParameterStudy(**(given | {"outputs": outputs} | changes)), tmp_path / name)

    thickness = lm.Parameter("system.strip.laminate.thickness", range=("1 mm", "3 mm"))
    load = lm.Parameter("system.load.force[2]", range=(-0.2, -0.1))
    both = run("lhs", parameters={"thickness": thickness, "load": load})
    assert {path.name for path in both.files} >= {"outputs.png", "sensitivity.png", "sensitivity.csv", "report.html", "table.csv"}
    words = lm.Parameter("system.strip.strain", values=("exact", "linear"))
    one = run("words", parameters={"strain": words}, design=lm.GridDesign())
    assert one["strain"].tolist() == ["exact", "linear"]
    assert one["z"] == pytest.approx(one["z"][0], rel=1e-3)  # it bends little
    assert "outputs.png" in {path.name for path in one.files}


def test_names_of_outputs_need_not_be_names_of_files(study: Path, tmp_path: Path, inline: list[int]) -> None:
    names = ("sag / load", "sag ? load", "../../sag", "s" * 300)
    output = lm.SignalOutput("tip.position", component="z")
    thickness = lm.Parameter("system.strip.laminate.thickness", values=("1 mm", "3 mm"))
    load = lm.Parameter("system.load.force[2]", values=(-0.2, -0.1))
    given = {"thickness": thickness, "load": load}, lm.GridDesign(), dict.fromkeys(names, output)
    result = lm.run_parameter_study(lm.ParameterStudy(str(tmp_path / "strip.yaml"), *given), tmp_path / "out")
    pictures = {path.name for path in (tmp_path / "out" / "pictures").iterdir()}
    assert pictures == {"map-sag _ load.png", "map-sag _ load_.png", "map-.._.._sag.png", f"map-{'s' * 80}.png"}
    assert pictures <= {path.name for path in result.files}


def test_failed_runs_are_kept_apart(here: Command, study: Path, tmp_path: Path, inline: list[int]) -> None:
    study.write_text(STUDY.replace("values: [-0.1 N, -0.2 N]", "values: [-0.1 N, many, -1e9 N]"))
    done = here("study", study, "--out", "out")
    assert done.returncode == 0, done.stderr
    rows = table(tmp_path / "out")
    assert [row["status"] for row in rows] == ["ok", "failed", "failed"] * 3
    assert "'many' is not a number" in rows[1]["message"]
    assert "analysis 'swing' stopped at" in rows[2]["message"]
    assert rows[1]["deflection [m]"] == ""
    assert "6 failed" in done.stdout
    assert "Runs that failed" in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_a_study_of_failures_alone_is_an_error(here: Command, study: Path, tmp_path: Path, inline: list[int]) -> None:
    study.write_text(STUDY.replace("values: [-0.1 N, -0.2 N]", "values: [-1e9 N]"))
    done = here("study", study, "--out", "out", "--quiet")
    assert done.returncode == 2
    assert "none of the 3 runs gave its outputs" in done.stderr
    assert len(table(tmp_path / "out")) == 3


def test_a_study_goes_on_where_it_ended(here: Command, study: Path, tmp_path: Path, inline: list[int]) -> None:
    assert here("study", study, "--out", "out", "--no-pictures").returncode == 0
    first, whole = list(inline), (tmp_path / "out" / "table.csv").read_bytes()
    (tmp_path / "out" / "runs" / "000002.json").unlink()
    (tmp_path / "out" / "runs" / "000004.json").write_text('{"number": 4, "sta')  # as a full disk leaves it
    lost = json.loads((tmp_path / "out" / "runs" / "000006.json").read_text()) | {"status": "lost"}
    (tmp_path / "out" / "runs" / "000006.json").write_text(json.dumps(lost))
    (tmp_path / "out" / "table.csv").unlink()
    left, written = (tmp_path / "out" / "runs" / f".part.{number}.000002.json" for number in (1, 2))
    for part in (left, written):
        part.write_text('{"number": 2, "sta')
    os.utime(left, (0, 0))  # by a process that was killed long ago; the other may be at work
    done = here("study", study, "--out", "out", "--no-pictures")
    assert (left.exists(), written.exists()) == (False, True)
    assert done.returncode == 0
    assert "3 of 6 runs are finished already" in done.stderr
    assert inline[len(first) :] == [2, 4, 6]
    assert (tmp_path / "out" / "table.csv").read_bytes() == whole


@pytest.mark.parametrize(
    ("old", "new", "parts"),
    [
        ("-0.2 N", "-0.3 N", "design"),
        ("statistic: min", "statistic: max", "outputs"),
        ("system.load.force[2]", "system.load.force[1]", "parameters"),
        ("design:", "set: ['analysis.swing.t_end=10 ms']\ndesign:", "model"),
    ],
)
def test_the_folder_of_another_study_is_refused(study: Path, tmp_path: Path, old: str, new: str, parts: str) -> None:
    Store(tmp_path / "out", read_study(study).checked(), overwrite=False).keep(Row(1, "ok"))
    study.write_text(STUDY.replace("title: Strip", "workers: 3"))
    assert list(Store(tmp_path / "out", read_study(study).checked(), overwrite=False).finished(6)) == [1]  # the same study
    assert old in STUDY
    study.write_text(STUDY.replace(old, new))
    other = read_study(study).checked()
    with pytest.raises(ResultFileError, match=f"'.*out' holds another study: it differs in {parts}; give --overwrite"):
        Store(tmp_path / "out", other, overwrite=False)
    assert not Store(tmp_path / "out", other, overwrite=True).finished(6)


def test_the_folder_of_a_run_is_left_alone(here: Command, study: Path, tmp_path: Path, inline: list[int]) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "run.h5").write_text("")
    done = here("study", study, "--out", "out", "--quiet")
    assert done.returncode == 2
    assert "holds results already" in done.stderr
    assert inline == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("study: 1\n", "", "the line 'study: 1' is missing"),
        ("design:", "desgin:", "line 7, desgin: parameter_study has no key 'desgin'; did you mean 'design'?"),
        ("kind: grid", "kind: gird", "line 7, design.kind: there is no kind 'gird'; did you mean 'grid'?"),
        ("kind: grid", "kind: sobol, runs: many, seed: 1", "line 7, design.runs: found 'many'"),
        ("kind: grid", "kind: sobol, runs: 8", "line 7, design: sobol needs 'seed'"),
        ("count: 3", "number: 3", "line 5, parameters.thickness.number: parameter has no key 'number'"),
        (", count: 3", "", "thickness: a grid needs 'values', or 'range' and 'count'"),
        ("3 mm]", "3 s]", "two numbers with the same unit"),
        (
            "1 mm, 3 mm",
            "1 s, 3 s",
            "line 5, parameters.thickness.path: no run of the study has a model that can be read",
        ),
        ("laminate.thickness", "laminate.thicknes", "laminate has no key 'thicknes'; did you mean 'thickness'?"),
        ("system.strip.lam", "system.stirp.lam", "system has no key 'stirp'; did you mean 'strip'?"),
        ("tip.position", "tip.positon", "line 9, outputs.deflection.signal: there is no signal 'tip.positon'; did you mean"),
        (
            "component: z",
            "component: w",
            "line 9, outputs.deflection.component: 'tip.position' has no component 'w'; accepted is x, y",
        ),
        (
            ", component: z",
            "",
            "line 9, outputs.deflection.signal: 'tip.position' is a vector, 'component' is missing; accepted is x",
        ),
        ("statistic: min", "statistic: least", "line 9, outputs.deflection.statistic: found 'least'"),
        (
            "statistic: min",
            "end: 1 s",
            "line 9, outputs.deflection.end: the window from 0 to 1 s; analysis 'swing' goes from 0 to 0.02 s",
        ),
        (
            "statistic: min",
            "analysis: swnig",
            "outputs.deflection.analysis: no analysis 'swnig' with signals; did you mean 'swing'?",
        ),
        (
            "{signal: tip.position, component: z, statistic: min}",
            "{kind: shape}",
            "analyses with frequencies or load factors are none",
        ),
        ("strip.yaml", "stripe.yaml", "line 3, model: the model file 'stripe.yaml' does not exist"),
        ("title: Strip", "title: [1]", "line 2, title"),
        ("  deflection:", "  message:", "line 8, outputs: the table has a column 'message' of its own; accepted is another name"),
        (
            "  deflection:",
            "  deflection [m]: {signal: load.factor}\n  deflection:",
            "line 10, outputs.deflection: the table has a column 'deflection [m]' already; accepted is another name",
        ),
        ("system.strip.laminate.thickness", "'..'", '--set ..="1.0 mm": accepted is key=value'),
        ("strip.yaml", "s" * 5000, "is neither a model file nor an example"),
        ("  thickness:", "  run:", "line 4, parameters: the table has a column 'run' of its own"),
        (
            "  deflection:",
            "  mass: {kind: mass, body: stirp}\n  deflection:",
            "line 9, outputs.mass.body: there is no body 'stirp' with mass; did you mean 'strip'?",
        ),
        (STUDY[STUDY.index("outputs:") :], "outputs: {}\n", "outputs is empty"),
        ("  thickness", " thickness", "not valid YAML"),
    ],
)
def test_bad_study_files_are_refused(here: Command, study: Path, tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in STUDY
    study.write_text(STUDY.replace(old, new, 1))
    done = here("study", study, "--out", "out")
    assert done.returncode == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_folder_that_cannot_be_is_refused(here: Command, study: Path) -> None:
    done = here("study", study, "--out", "x" * 300)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "cannot be written: File name too long" in done.stderr


def test_a_model_file_is_no_study_file(here: Command, model: Path) -> None:
    done = here("study", model)
    assert done.returncode == 2
    assert "is a model file; 'lamella run" in done.stderr


def test_a_study_file_is_no_model_file(here: Command, study: Path) -> None:
    done = here("run", study)
    assert done.returncode == 2
    assert "is a study file; 'lamella study" in done.stderr
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize("address", ["nonsense", "foo://here:1", "tcp://127.0.0.1:9", "tls://127.0.0.1:9"])
def test_a_cluster_that_cannot_be_reached_is_told(here: Command, study: Path, monkeypatch: pytest.MonkeyPatch, address) -> None:
    monkeypatch.setattr(lamella.sweep.cluster, "TIMEOUT", 0.3)
    done = here("study", study, "--out", "out", "--cluster", address, "--quiet")
    assert done.returncode == 2
    assert f"the cluster '{address}' cannot be reached within 0.3 s" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_scheduler_of_dask_runs_a_study(study: Path, tmp_path: Path, inline: list[int]) -> None:
    from distributed import LocalCluster

    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp://") as cluster:
        study.write_text(STUDY + f"cluster: {cluster.scheduler_address}\n")
        result = lm.run_parameter_study(read_study(study), tmp_path / "out", pictures=False)
    assert inline == []
    assert result.ok.all()
    again = lm.run_parameter_study(read_study(study), tmp_path / "out", pictures=False)  # nothing is left for a cluster
    assert again["deflection"].tolist() == result["deflection"].tolist()


def test_workers_of_another_version_are_refused(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr(lamella.sweep.cluster, "__version__", "9.9")
    with LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp://") as cluster:
        study.write_text(STUDY + f"cluster: {cluster.scheduler_address}\n")
        with pytest.raises(WorkerError, match=r"has lamella .*, here is 9\.9.*0 of 6 runs are finished and kept"):
            lm.run_parameter_study(read_study(study), tmp_path / "out", pictures=False)


@pytest.fixture(params=["forked", "started alone"])
def origin(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Where worker processes come from: the one that is used on Linux, and that of other systems."""
    if request.param == "started alone":
        monkeypatch.setattr(lamella.sweep.local, "begin", Spawns)
    elif sys.platform != "linux":
        pytest.skip("workers are forked on Linux alone")
    return request.param


def worker_processes(origin: str) -> list[int]:
    """Numbers of the worker processes there are, of which only those that are not forked are children of this one."""
    children = [child.pid or 0 for child in multiprocessing.active_children()]
    if origin == "started alone":
        return children
    return [int(pid) for child in children for pid in Path(f"/proc/{child}/task/{child}/children").read_text().split()]


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_a_killed_worker_does_not_lose_the_study(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, origin: str
) -> None:
    """Two worker processes; one is killed when the first run is finished, and its run is done by another process."""
    killed: list[int] = []
    workers: list[int] = []
    keep = Store.keep

    def keep_and_kill(store: Store, row: Row) -> None:
        keep(store, row)
        if not killed:
            workers.extend(worker_processes(origin))
            killed.append(workers[0])
            os.kill(killed[0], signal.SIGKILL)
        elif len(workers) == 2:
            workers.extend(worker_processes(origin))

    monkeypatch.setattr(Store, "keep", keep_and_kill)
    said: list[str] = []
    model = (tmp_path / "strip.yaml").read_text()
    (tmp_path / "strip.yaml").write_text(
        model[: model.index("analysis:")] + "analysis: {modes: {type: natural_modes, count: 1}}\n"
    )
    study.write_text(STUDY[: STUDY.index("outputs:")] + "outputs: {frequency: {kind: shape}}\nworkers: 2\n")
    source = read_study(study)
    result = lm.run_parameter_study(source, tmp_path / "out", pictures=False, say=said.append)
    assert killed
    assert len([text for text in said if "its worker process ended; it is run again" in text]) <= 1  # none when it was idle
    assert result.ok.all()
    checked = source.checked()
    for row, settings in zip(result.rows, map(source.study.settings, source.study.rows()), strict=True):
        here = run_task(Task(row.number, checked.text, "strip", tmp_path, settings, source.study.outputs))
        assert here.values == row.values  # to the last bit: the same work, whoever does it
    wait_until_ended(workers)


def wait_until_ended(processes: list[int]) -> None:
    end = time.monotonic() + DEADLINE
    while any(map(is_running, processes)):
        multiprocessing.active_children()  # those that have ended are laid to rest
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")
def test_the_process_that_is_forked_may_be_killed(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And then one of the workers it left, in whose place another is started alone."""
    killed: list[int] = []
    keep = Store.keep

    def keep_and_kill(store: Store, row: Row) -> None:
        keep(store, row)
        if not killed:
            worker = worker_processes("forked")[0]
            killed.extend([multiprocessing.active_children()[0].pid or 0, worker])
            for process in killed:
                os.kill(process, signal.SIGKILL)

    monkeypatch.setattr(Store, "keep", keep_and_kill)
    study.write_text(STUDY + "workers: 2\n")
    result = lm.run_parameter_study(read_study(study), tmp_path / "out", pictures=False)
    assert killed
    assert result.ok.all()
    wait_until_ended(killed)
    for child in multiprocessing.active_children():
        child.join(DEADLINE)
        assert not child.is_alive()


SCRIPT = """\
import threading, time
threading.Thread(target=time.sleep, args=(600.0,), daemon=True).start()
import lamella as lm
from lamella.sweep.study import read_study
if __name__ == "__main__":
    result = lm.run_parameter_study(read_study("study.yaml"), "out", pictures=False)
    print(result.ok.sum(), "runs")
"""


def test_scripts_that_start_threads_may_run_studies(study: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    """Which a fork would leave in an unknown state."""
    study.write_text(STUDY + "workers: 1\n")
    (tmp_path / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout == "6 runs\n"
    assert done.stderr == ""


def end_at_once(*_: object) -> None:
    os._exit(1)


def test_workers_that_always_die_are_given_up(study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, origin: str) -> None:
    monkeypatch.setattr(lamella.sweep.processes, "serve_forks", end_at_once)
    monkeypatch.setattr(lamella.sweep.processes, "work", end_at_once)
    with pytest.raises(WorkerError, match=r"__main__.*0 of 6 runs are finished and kept"):
        lm.run_parameter_study(read_study(study), tmp_path / "out", pictures=False)


def test_a_run_that_always_kills_its_worker_is_given_up(tmp_path: Path, origin: str) -> None:
    said: list[str] = []
    with LocalWorkers(2, said.append) as workers:
        tasks = [Task(k, "", "strip", tmp_path, (), {"ends": Deadly()} if k == 2 else {}) for k in range(1, 5)]
        rows = {row.number: row for row in workers.run(tasks)}
    assert [rows[k].status for k in range(1, 5)] == ["failed", "lost", "failed", "failed"]
    assert rows[2].message == "its worker process ended, 3 times"
    assert [text.partition("; ")[2] for text in said] == ["it is run again", "it is run again", "given up"]


class Deadly:
    """Ends the process that it comes to."""

    def __reduce__(self) -> tuple[Any, tuple[int]]:
        return os._exit, (1,)


@pytest.mark.skipif(sys.platform != "linux", reason="workers are forked on Linux alone")
def test_a_bad_study_leaves_no_process(study: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    study.write_text(STUDY.replace("tip.position", "tip.positon"))
    refused = start(environment, tmp_path)
    out, error = refused.communicate(timeout=DEADLINE)  # ends when nobody holds the pipes any more
    assert refused.returncode == 2
    assert out == ""
    assert "there is no signal 'tip.positon'" in error
    assert len(error.splitlines()) == 1


def start(environment: dict[str, str], folder: Path, *words: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "lamella", "study", "study.yaml", "--out", "out", "--no-pictures", *words]
    return subprocess.Popen(command, cwd=folder, env=environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


@pytest.fixture
def long_study(study: Path) -> Path:
    """Forty runs of a second or so."""
    text = STUDY.replace("range: [1 mm, 3 mm], count: 3", "range: [1 mm, 3 mm], count: 20")
    study.write_text(text.replace("design:", "set: ['analysis.swing.t_end=200 ms']\ndesign:"))
    return study


@pytest.mark.slow
def test_an_interrupted_and_a_killed_study_go_on(long_study: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    first = start(environment, tmp_path, "--workers", "2")
    wait_for_runs(tmp_path / "out", 5)
    first.send_signal(signal.SIGINT)
    error = first.communicate(timeout=DEADLINE)[1]
    assert first.returncode == 130
    assert "of 40 runs are finished and kept in 'out'; the same command goes on from there" in error
    second = start(environment, tmp_path, "--workers", "2")
    wait_for_runs(tmp_path / "out", 20)
    second.kill()
    second.communicate(timeout=DEADLINE)
    before = kept(tmp_path / "out")
    assert 20 <= len(before) < 40
    third = start(environment, tmp_path, "--workers", "1")
    third.communicate(timeout=DEADLINE)
    assert third.returncode == 0
    after = kept(tmp_path / "out")
    assert len(after) == 40
    assert {name: after[name] for name in before} == before  # none was repeated
    resumed = (tmp_path / "out" / "table.csv").read_bytes()
    whole = start(environment, tmp_path, "--workers", "2", "--overwrite")
    whole.communicate(timeout=DEADLINE)
    assert (tmp_path / "out" / "table.csv").read_bytes() == resumed


@pytest.fixture
def cluster(environment: dict[str, str], tmp_path: Path) -> Generator[tuple[str, list[subprocess.Popen[bytes]]], None, None]:
    """A scheduler and two workers of Dask as processes of their own: its address, and the processes."""
    file = tmp_path / "scheduler.json"
    words = ["--scheduler-file", str(file), "--no-dashboard"]
    quiet: dict[str, Any] = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    scheduler = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--host", "127.0.0.1", *words]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--nthreads", "1", "--no-nanny", *words]
    processes = [subprocess.Popen(scheduler, **quiet)]
    end = time.monotonic() + DEADLINE
    while not file.exists():
        assert processes[0].poll() is None
        assert time.monotonic() < end
        time.sleep(0.05)
    processes += [subprocess.Popen(worker, **quiet) for _ in range(2)]
    yield json.loads(file.read_text())["address"], processes
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.slow
def test_a_cluster_loses_a_worker_and_then_its_scheduler(long_study: Path, tmp_path: Path, environment, cluster) -> None:
    address, (scheduler, worker, _) = cluster
    running = start(environment, tmp_path, "--cluster", address)
    wait_for_runs(tmp_path / "out", 5)
    worker.kill()
    error = running.communicate(timeout=DEADLINE)[1]
    assert running.returncode == 0, error
    assert {row["status"] for row in table(tmp_path / "out")} == {"ok"}
    by_cluster = (tmp_path / "out" / "table.csv").read_bytes()

    shutil.rmtree(tmp_path / "out")
    running = start(environment, tmp_path, "--cluster", address)
    wait_for_runs(tmp_path / "out", 5)
    scheduler.kill()
    error = running.communicate(timeout=DEADLINE)[1]
    assert running.returncode == 2
    assert f"the cluster '{address}' was lost" in error
    assert "Traceback" not in error
    assert len(kept(tmp_path / "out")) >= 5
    here = start(environment, tmp_path, "--workers", "2")
    error = here.communicate(timeout=DEADLINE)[1]
    assert "runs are finished already" in error
    assert (tmp_path / "out" / "table.csv").read_bytes() == by_cluster


@pytest.mark.slow
def test_a_scheduler_that_answers_no_more_is_told(
    long_study: Path, tmp_path: Path, cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    address, (scheduler, *_) = cluster
    monkeypatch.setattr(lamella.sweep.cluster, "PATIENCE", 0.5)
    monkeypatch.setattr(lamella.sweep.cluster, "FROZEN", 1.0)

    def freeze() -> None:
        wait_for_runs(tmp_path / "out", 3)
        scheduler.send_signal(signal.SIGSTOP)

    freezing = threading.Thread(target=freeze)
    freezing.start()
    source = read_study(long_study)
    source = replace(source, study=replace(source.study, cluster=address))
    with pytest.raises(WorkerError, match=r"was lost; .* runs are finished and kept"):
        lm.run_parameter_study(source, tmp_path / "out", pictures=False)
    freezing.join()
    assert len(kept(tmp_path / "out")) >= 3
