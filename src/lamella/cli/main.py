"""The command line ``lamella``. Everything heavy is imported inside the commands, so that help answers at once."""

from __future__ import annotations

import gc
import os
import sys
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from lamella.errors import LamellaError

ERROR, INTERRUPTED = 2, 130
BETWEEN_COLLECTIONS = 200_000
"""Objects made before Python looks for garbage. A start makes some hundred thousand, which stay: at Python's own 700 to 2000 it
looks through all of them several times, for a tenth of the start. Models hold no cycles, so that little is left lying."""


class Interrupted(Exception):  # noqa: N818  # it is no error
    """Ctrl-C, with a sentence on how far the run got."""


app = typer.Typer(
    name="lamella",
    help="Flexible multibody dynamics of thin plates and shells, from a model file to results and pictures.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,  # plain help: half the start-up time
    context_settings={"help_option_names": ["-h", "--help"]},
)
example_app = typer.Typer(help="List the examples, or copy one to change it.", no_args_is_help=True, rich_markup_mode=None)
app.add_typer(example_app, name="examples")

Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Replace a value of the model file, e.g. system.plate.mesh=[8,8]. May be repeated."
    ),
]
Threads = Annotated[
    int | None, typer.Option("--threads", min=1, help="Threads of the computation, for large models; one when left out.")
]
OutFolder = Annotated[Path | None, typer.Option("--out", "-o", help="Folder of the results; results/NAME when left out.")]


def _version(asked: bool) -> None:
    if asked:
        from lamella.io.provenance import versions

        print(f"lamella {versions()['lamella']}")
        raise typer.Exit


def _use_threads(count: int | None) -> None:
    """Use so many threads; a wrong number in the environment is refused before anything is written."""
    from lamella import threads

    threads.use(count)
    threads.number()


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version and leave.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Flexible multibody dynamics of thin plates and shells, from a model file to results and pictures."""


@app.command("run")
def run_model(
    model: Annotated[str, typer.Argument(help="A model file, or the name of an example.", metavar="FILE|EXAMPLE")],
    out: OutFolder = None,
    settings: Settings = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in the folder.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Write data only: no plots, pictures or report.")] = False,
    threads: Threads = None,
) -> None:
    """Compute what a model file asks for and write results, pictures and a report page."""
    from lamella.cli.run import run_command

    _use_threads(threads)
    try:
        run_command(model, out, settings or [], overwrite=overwrite, quiet=quiet, pictures=not no_pictures)
    except KeyboardInterrupt as error:
        raise Interrupted(str(error)) from error


@app.command()
def study(
    file: Annotated[Path, typer.Argument(help="A study file.", metavar="STUDY")],
    out: OutFolder = None,
    settings: Settings = None,
    workers: Annotated[int | None, typer.Option("--workers", "-w", min=1, help="Processes on this machine; its cores.")] = None,
    cluster: Annotated[
        str | None, typer.Option("--cluster", help="Address of a Dask scheduler, which runs them instead.")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Start anew, whatever the folder holds.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Write the table only: no plots or report.")] = False,
) -> None:
    """Run a model at many values of its parameters; goes on with a study that was interrupted."""
    from lamella.sweep.processes import begun

    with begun() if cluster is None else nullcontext():  # before the rest is imported: workers start beside it
        from lamella.cli.study import study_command

        try:
            study_command(
                file,
                out,
                settings or [],
                workers=workers,
                cluster=cluster,
                overwrite=overwrite,
                quiet=quiet,
                pictures=not no_pictures,
            )
        except KeyboardInterrupt as error:
            raise Interrupted(str(error)) from error


@app.command()
def optimize(
    file: Annotated[Path, typer.Argument(help="An optimisation file.", metavar="OPTIMIZE")],
    out: OutFolder = None,
    settings: Settings = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the results in the folder.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Show errors only.")] = False,
    no_pictures: Annotated[
        bool, typer.Option("--no-pictures", help="Write the table only: no run of the best, no report.")
    ] = False,
    threads: Threads = None,
) -> None:
    """Look for the values of parameters at which an output is best, by gradients."""
    from lamella.cli.optimise import optimise_command

    _use_threads(threads)
    try:
        optimise_command(file, out, settings or [], overwrite=overwrite, quiet=quiet, pictures=not no_pictures)
    except KeyboardInterrupt as error:
        raise Interrupted(str(error)) from error


@app.command()
def new(
    name: Annotated[str | None, typer.Argument(help="The file to write; .yaml is added.")] = None,
    template: Annotated[str, typer.Option("--template", "-t", help="Which template.")] = "cantilever",
    list_all: Annotated[bool, typer.Option("--list", help="List the templates.")] = False,
) -> None:
    """Write a model file to start from."""
    from lamella.cli.files import list_templates, write_template

    if list_all:
        list_templates()
    elif name is None:
        raise typer.BadParameter("a name is needed, for example 'lamella new wing', or --list")
    else:
        write_template(name, template)


@example_app.command("list")
def examples_list() -> None:
    """List the examples."""
    from lamella.cli.files import list_examples

    list_examples()


@example_app.command("copy")
def examples_copy(
    name: Annotated[str, typer.Argument(help="Name of the example.")],
    folder: Annotated[Path | None, typer.Argument(help="Where to; a folder of the example's name when left out.")] = None,
) -> None:
    """Copy an example's files."""
    from lamella.cli.files import copy_example

    copy_example(name, folder)


@app.command()
def info(path: Annotated[Path, typer.Argument(help="A result file, a folder of results, or a model file.")]) -> None:
    """Show what is in a result or a model file."""
    from lamella.cli.info import info_command

    info_command(path)


@app.command()
def verify(
    cases: Annotated[list[str] | None, typer.Argument(help="Names of cases; all when left out.", metavar="[CASE]...")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print a list of objects instead of a table.")] = False,
    list_all: Annotated[bool, typer.Option("--list", help="List the cases; nothing is run.")] = False,
    fast: Annotated[bool, typer.Option("--fast", help="Leave out the slow cases.")] = False,
    report: Annotated[Path | None, typer.Option("--report", help="Also write the verification manual, an HTML page.")] = None,
) -> None:
    """Run the cases with a known answer; exit with 1 when one fails."""
    from lamella.cli.verify import list_cases, verify_command

    if list_all:
        list_cases(cases or [], as_json)
    else:
        raise typer.Exit(verify_command(cases or [], as_json=as_json, fast=fast, report=report))


@app.command()
def bench(
    cases: Annotated[
        list[str] | None, typer.Argument(help="Names of benchmarks; all when left out.", metavar="[CASE]...")
    ] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of the tables and pictures.")] = Path("results/bench"),
    runs: Annotated[int, typer.Option("--runs", min=1, help="Repetitions; the table has the median.")] = 3,
    list_all: Annotated[bool, typer.Option("--list", help="List the benchmarks; nothing is run.")] = False,
) -> None:
    """Time lamella and the other codes that are installed on the same cases, on one core."""
    from lamella.cli.bench import bench_command, list_benchmarks

    if list_all:
        list_benchmarks()
    else:
        bench_command(cases or [], out, runs)


@app.command()
def plot(
    result: Annotated[Path, typer.Argument(help="A result file, or a folder with run.h5.")],
    signals: Annotated[
        list[str] | None, typer.Argument(help="Signals such as tip.position; all when left out.", metavar="[SIGNAL]...")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The picture to write (.png, .svg or .pdf).")] = None,
) -> None:
    """Plot recorded signals."""
    from lamella.cli.export import plot_command

    plot_command(result, signals or [], out)


@app.command()
def export(
    result: Annotated[Path, typer.Argument(help="A result file, or a folder with run.h5.")],
    to: Annotated[
        str, typer.Option("--to", help="vtkhdf (ParaView), csv (signals), png, gif (animation), html (report) or yaml (model).")
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The file to write; beside the result when left out.")] = None,
) -> None:
    """Write a result in another form."""
    from lamella.cli.export import export_command

    export_command(result, to, out)


@app.command()
def fmu(
    model: Annotated[str, typer.Argument(help="A model file, or the name of an example.", metavar="FILE|EXAMPLE")],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="The unit to write; NAME.fmu when left out.")] = None,
    fmi: Annotated[int, typer.Option("--fmi", help="Version of FMI: 2 or 3.")] = 2,
    inputs: Annotated[
        list[str] | None, typer.Option("--input", help="A load, drive or support; those of the linear analysis when left out.")
    ] = None,
    outputs: Annotated[
        list[str] | None, typer.Option("--output", help="A signal such as tip.position.z; those of the linear analysis.")
    ] = None,
    step: Annotated[float | None, typer.Option("--step", help="Proposed communication step [s]; the integrator's.")] = None,
    settings: Settings = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
) -> None:
    """Write a model as a functional mock-up unit (FMI) for co-simulation in other programs."""
    from lamella.cli.fmu import fmu_command

    fmu_command(model, out, fmi, inputs, outputs, step=step, settings=settings or [], overwrite=overwrite)


@app.command()
def doctor() -> None:
    """Check the installation; exit with 1 and advice when something is wrong."""
    from lamella.cli.doctor import doctor_command

    raise typer.Exit(doctor_command())


@app.command()
def schema(
    out: Annotated[Path | None, typer.Argument(help="The file to write; printed when left out.")] = None,
    of: Annotated[str, typer.Option("--of", help="The kind of file: model, study or optimize.")] = "model",
) -> None:
    """Write the JSON Schema of a model, study or optimisation file, for completion and checking in editors."""
    from lamella.cli.files import write_schema

    write_schema(out, of)


def run_app(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; errors raised on purpose become one message.

    Args:
        arguments: words after ``lamella``; those of the process when left out.
    """
    try:
        code = app(arguments, standalone_mode=False)
    except typer.Exit as leave:
        return leave.exit_code
    except (typer.Abort, Interrupted) as error:
        return _interrupted(str(error))
    except LamellaError as error:
        print(f"lamella: {error}", file=sys.stderr)
        return ERROR
    except Exception as error:
        show = getattr(error, "show", None)  # a wrong option or argument explains itself
        if show is None:
            raise
        show()
        return ERROR
    if code == INTERRUPTED:  # typer has turned Ctrl-C into this code
        return _interrupted()
    return code if isinstance(code, int) else 0


def _interrupted(text: str = "") -> int:
    print(f"lamella: interrupted{f': {text}' if text else ''}", file=sys.stderr)
    return INTERRUPTED


def run() -> None:
    """Entry point of the command ``lamella``."""
    gc.set_threshold(BETWEEN_COLLECTIONS)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # else it looks for some in every package that is installed
    code = run_app()
    gc.freeze()  # or Python would look through everything for garbage once more before it ends: 0.3 s
    sys.exit(code)
