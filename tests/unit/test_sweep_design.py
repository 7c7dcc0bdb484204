"""Designs, parameters and outputs of parameter studies, without running a model."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy import stats

import lamella as lm
from lamella.errors import DeclarationError
from lamella.io.document import plain_value
from lamella.sweep.designs import design_rows
from lamella.sweep.outputs import STATISTICS
from lamella.sweep.parameter import columns_of, quantity_of
from lamella.sweep.sensitivity import sensitivities, sobol_indices
from lamella.sweep.study import ParameterStudy
from lamella.sweep.table import StudyResult
from lamella.sweep.task import Row

THICKNESS = lm.Parameter("laminates.panel.thickness", range=("1 mm", "3 mm"))
LOAD = lm.Parameter("system.load.force[2]", range=(-2.0, 2.0))
OUTPUT = {"y": lm.SignalOutput("tip.position", component="z")}


def shares(rows, name, parameter):
    low, high, _ = parameter.bounds
    return np.array([(quantity_of(row[name])[0] - low) / (high - low) for row in rows])


def test_a_grid_that_no_memory_holds_is_refused_by_its_number_of_runs() -> None:
    vast = lm.Parameter("system.plate.mesh", range=(0.0, 1.0), count=10**15)
    with pytest.raises(ValueError, match=f"the design has {10**15} runs; accepted are at most 100000"):
        design_rows(lm.GridDesign(), {"mesh": vast})


def test_a_grid_has_all_combinations_the_last_fastest() -> None:
    parameters = {
        "mesh": lm.Parameter("system.plate.mesh", values=([2, 2], [4, 4])),
        "h": lm.Parameter("laminates.panel.thickness", range=("1 mm", "2 mm"), count=3),
    }
    rows = design_rows(lm.GridDesign(), parameters)
    assert [tuple(row.values()) for row in rows] == list(itertools.product(([2, 2], [4, 4]), ("1.0 mm", "1.5 mm", "2.0 mm")))


def test_logarithmic_values_have_equal_ratios() -> None:
    values = lm.Parameter("a.b", range=(1.0, 100.0), count=3, scale="log").grid()
    assert values == pytest.approx([1.0, 10.0, 100.0], rel=1e-14)


@pytest.mark.parametrize("design", [lm.LatinHypercubeDesign(16, seed=3), lm.SobolDesign(16, seed=3)])
def test_samples_put_one_value_in_each_part_of_a_range(design) -> None:
    parameters = {"h": THICKNESS, "load": LOAD}
    rows = design_rows(design, parameters)
    for name, parameter in parameters.items():  # both designs have this property, Sobol's for powers of two
        assert sorted(np.floor(16 * shares(rows, name, parameter))) == list(range(16))
    assert design_rows(design, parameters) == rows
    assert design_rows(type(design)(16, seed=4), parameters) != rows


def test_a_saltelli_design_is_two_samples_and_their_mixtures() -> None:
    parameters = {"h": THICKNESS, "load": LOAD}
    A, B, AB1, AB2 = np.split(np.array([list(row.values()) for row in design_rows(lm.SaltelliDesign(8, seed=1), parameters)]), 4)
    assert not (A == B).any()
    assert (AB1[:, 0] == B[:, 0]).all()
    assert (AB1[:, 1] == A[:, 1]).all()
    assert (AB2[:, 0] == A[:, 0]).all()
    assert (AB2[:, 1] == B[:, 1]).all()


def test_a_list_gives_its_rows_in_the_order_of_the_parameters() -> None:
    parameters = {"a": lm.Parameter("x.a"), "b": lm.Parameter("x.b")}
    rows = design_rows(lm.ListDesign(({"b": 1, "a": "exact"}, {"a": "linear", "b": 2})), parameters)
    assert [list(row.items()) for row in rows] == [[("a", "exact"), ("b", 1)], [("a", "linear"), ("b", 2)]]


@pytest.mark.parametrize(
    ("value", "number"),
    [
        ("1 mm", (1.0, "mm")),
        ("-1e-3m", (-1e-3, "m")),
        (4, (4.0, "")),
        ("exact", None),
        ([1, 2], None),
        (True, None),
        ("10 %", (10.0, "%")),
        ("2.3e-5 1/K", (2.3e-5, "1/K")),
        ("20 1/(m s)", (20.0, "1/(m s)")),
        ("2.31/K", None),
        ("2 3", None),
    ],
)
def test_numbers_and_units_are_told_apart(value, number) -> None:
    assert quantity_of(value) == number


@pytest.mark.parametrize("value", ["1.5 mm", [4, 4], "exact", True, 3, 1e-300, 0.1 + 0.2, "a: b", None])
def test_a_setting_gives_the_same_value_back(value) -> None:
    (text,) = lm.Parameter("a.b").settings(value)
    assert plain_value(text.partition("=")[2]) == value


def test_several_paths_take_a_value_times_their_factors() -> None:
    parameter = lm.Parameter({"x.angles[0]": 1.0, "x.angles[1]": -1.0, "x.h": 0.5})
    assert parameter.settings("30 deg") == ['x.angles[0]="30 deg"', 'x.angles[1]="-30.0 deg"', 'x.h="15.0 deg"']
    with pytest.raises(DeclarationError, match="'exact' times the factor -1"):
        parameter.settings("exact")


def test_columns_are_numbers_where_units_agree() -> None:
    rows = [{"h": "1 mm", "n": 4, "mixed": "1 mm", "mesh": [2, 2]}, {"h": "2 mm", "n": 8, "mixed": "1 m", "mesh": [4, 4]}]
    found = columns_of(rows, ["h", "n", "mixed", "mesh"])
    assert found == {
        "h": ("mm", [1.0, 2.0]),
        "n": ("", [4.0, 8.0]),
        "mixed": ("", ["1 mm", "1 m"]),
        "mesh": ("", ["[2, 2]", "[4, 4]"]),
    }


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: lm.Parameter(" "), "path is empty"),
        (lambda: lm.Parameter("a=2", values=(1,)), "path = a=2; accepted is the path of a value, without '='"),
        (lambda: lm.Parameter({"a": float("inf")}, values=(1,)), "the factor of a is inf; accepted is a finite number"),
        (lambda: lm.Parameter("a", range=(0.0, float("inf"))), "accepted are finite numbers"),
        (lambda: lm.Parameter("a", range=("0 mm", "1e400 mm")), "accepted are finite numbers"),
        (lambda: lm.Parameter("a", range=(-1e308, 1e308)), "accepted are finite numbers"),
        (lambda: lm.Parameter("a", values=(1,), range=(0, 1)), "values and range are both given"),
        (lambda: lm.Parameter("a", values=()), "values is empty"),
        (lambda: lm.Parameter("a", range=("1 mm", "1 m")), "two numbers with the same unit"),
        (lambda: lm.Parameter("a", values=(np.int64(3),)), "of type int64; accepted are numbers, text"),
        (lambda: lm.Parameter("a", values=(float("nan"),)), "nan of type float; accepted are numbers"),
        (lambda: study({"h": lm.Parameter("a")}, lm.ListDesign(({"h": {1}},))), r"runs\[0\]: h: \{1\} of type set; accepted are"),
        (lambda: lm.Parameter("a", range=(2, 1)), "a lower value before a higher one"),
        (lambda: lm.Parameter("a", range=(0, 1), scale="log"), "above zero"),
        (lambda: lm.SobolDesign(100, seed=1), "power of two, such as 64 or 128"),
        (lambda: lm.SaltelliDesign(3, seed=1), "power of two, such as 2 or 4"),
        (lambda: lm.LatinHypercubeDesign(1, seed=1), "at least 2"),
        (lambda: study({}, lm.GridDesign()), "the design is empty"),
        (lambda: study({"h": THICKNESS}, lm.ListDesign(())), "the design is empty"),
        (lambda: study({"h": THICKNESS}, lm.GridDesign()), "h: a grid needs 'values', or 'range' and 'count'"),
        (lambda: study({"h": lm.Parameter("a")}, lm.SobolDesign(4, seed=1)), "h: this design draws values from a range"),
        (
            lambda: study({"h": lm.Parameter("a")}, lm.ListDesign(({"g": 1},))),
            r"runs\[0\] gives g; accepted is a value for each of h",
        ),
        (lambda: study({"h": THICKNESS}, lm.ListDesign(({"h": 1},))), "h: a list of runs gives the values"),
        (
            lambda: study({str(k): lm.Parameter(f"a{k}", values=tuple(range(9))) for k in range(9)}, lm.GridDesign()),
            "387420489 runs",
        ),
        (
            lambda: study({"h": lm.Parameter("a", values=(1,)), "g": lm.Parameter(" a ", values=(1,))}, lm.GridDesign()),
            "path a is",
        ),
        (lambda: study({" ": THICKNESS}, lm.SobolDesign(4, seed=1)), "parameters: a name is empty"),
        (lambda: study({"h": THICKNESS, "g": THICKNESS}, lm.SobolDesign(4, seed=1)), "is that of the parameter 'h' already"),
        (lambda: study({"y": THICKNESS}, lm.SobolDesign(4, seed=1)), "both called y"),
        (lambda: lm.ParameterStudy("m", {"h": THICKNESS}, lm.SobolDesign(4, seed=1), {}), "outputs is empty"),
    ],
)
def test_what_cannot_be_is_refused(make, said) -> None:
    with pytest.raises(DeclarationError, match=said):
        make()


def study(parameters, design) -> ParameterStudy:
    return lm.ParameterStudy("m", parameters, design, OUTPUT)


@pytest.mark.parametrize(
    ("name", "wanted"),
    # z = t on [0, 2], sampled unevenly: exact but for rms and std, whose integrand is a parabola: h^2/12 of the trapezoidal rule
    [
        ("last", 2.0),
        ("max", 2.0),
        ("min", 0.0),
        ("largest", 2.0),
        ("mean", 1.0),
        ("rms", np.sqrt(4 / 3)),
        ("std", np.sqrt(1 / 3)),
        ("slope", 1.0),
    ],
)
def test_statistics_weigh_by_time(name, wanted) -> None:
    t = 2.0 * np.linspace(0.0, 1.0, 2001) ** 2
    assert STATISTICS[name](t, t) == pytest.approx(wanted, abs=0.0 if name in ("last", "max", "min", "largest") else 2e-6)


def test_a_slope_is_that_of_least_squares() -> None:
    """Of 3 t^2 on [0, 2] 6, wherever the samples lie; NumPy's on equal steps but for the ends, which weigh half here."""
    t = 2.0 * np.linspace(0.0, 1.0, 2001) ** 2
    assert STATISTICS["slope"](t, 3.0 * t**2) == pytest.approx(6.0, rel=2e-6)
    t = np.linspace(1.0, 3.0, 2001)
    z = np.sin(5.0 * t)
    assert STATISTICS["slope"](t, z) == pytest.approx(np.polyfit(t, z, 1)[0], abs=5e-3)


def ishigami(x: np.ndarray) -> np.ndarray:
    """Ishigami and Homma (1990), a = 7, b = 0.1; x of shape (3, n)."""
    return np.sin(x[0]) + 7.0 * np.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * np.sin(x[0])


@pytest.fixture(scope="module")
def ishigami_result() -> StudyResult:
    parameters = {f"x{k}": lm.Parameter(f"a.x{k}", range=(-np.pi, np.pi)) for k in (1, 2, 3)}
    chosen = study(parameters, lm.SaltelliDesign(4096, seed=7))
    values = ishigami(np.array([[row[name] for row in chosen.rows()] for name in parameters]))
    return StudyResult(chosen, {"y": "m"}, [Row(k, "ok", {"y": value}) for k, value in enumerate(values, start=1)])


def test_sobol_indices_are_those_of_the_ishigami_function(ishigami_result: StudyResult) -> None:
    V1, V2, V13 = 0.5 * (1.0 + 0.1 * np.pi**4 / 5) ** 2, 49.0 / 8.0, 0.01 * np.pi**8 * (1 / 18 - 1 / 50)  # closed form
    V = V1 + V2 + V13
    exact = {"x1": (V1 / V, (V1 + V13) / V), "x2": (V2 / V, V2 / V), "x3": (0.0, V13 / V)}
    for item in sensitivities(ishigami_result):
        wanted = exact[item.parameter][item.measure == "total"]
        assert item.value == pytest.approx(wanted, abs=0.03)  # 3/sqrt(4096) would be 0.05 for random points; Sobol's are better
        assert item.low <= item.value <= item.high


def test_sobol_indices_are_those_of_scipy(ishigami_result: StudyResult) -> None:
    values = ishigami_result["y"].reshape(5, 4096)
    theirs = stats.sobol_indices(func={"f_A": values[:1], "f_B": values[1:2], "f_AB": values[2:, None]}, n=4096)
    first, total = sobol_indices(values[0], values[1], values[2:])
    np.testing.assert_allclose(first, np.ravel(theirs.first_order), atol=1e-12)
    np.testing.assert_allclose(total, np.ravel(theirs.total_order), atol=1e-12)


def test_points_with_a_failed_run_are_left_out_of_the_indices(ishigami_result: StudyResult) -> None:
    rows = list(ishigami_result.rows)
    rows[5000] = Row(5001, "failed", message="no")  # of B: point 904
    found = sensitivities(StudyResult(ishigami_result.study, {"y": "m"}, rows))
    kept = np.delete(ishigami_result["y"].reshape(5, 4096), 904, axis=1)
    first, _ = sobol_indices(kept[0], kept[1], kept[2:])
    assert [item.value for item in found if item.measure == "first order"] == pytest.approx(first, abs=1e-14)


def test_rank_correlation_is_one_where_an_output_always_rises() -> None:
    chosen = study({"h": THICKNESS, "load": LOAD}, lm.LatinHypercubeDesign(64, seed=1))
    h = [quantity_of(row["h"])[0] for row in chosen.rows()]
    result = StudyResult(chosen, {"y": "m"}, [Row(k, "ok", {"y": x**3}) for k, x in enumerate(h, start=1)])
    first, second = sensitivities(result)
    assert (first.parameter, first.value) == ("h", pytest.approx(1.0, abs=1e-12))
    assert abs(second.value) < 3.0 / np.sqrt(64)  # three standard errors of independent ranks
    assert second.low < second.value < second.high
