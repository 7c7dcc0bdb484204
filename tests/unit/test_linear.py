"""Linear solvers against dense NumPy, on definite, indefinite, saddle-point, unsymmetric and singular matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from lamella.assembly.pattern import Pattern
from lamella.errors import MissingExtraError, SingularSystemError
from lamella.roles import Floats
from lamella.solve.linear import AutomaticSolver, LinearSolver, Method, linear_solver
from lamella.solve.multifrontal import Multifrontal
from lamella.solve.pardiso import library
from lamella.solve.schur import SchurSolver

UNITS = np.tile(np.repeat([1.0, 1e-1, 1e-1, 1e-3], 3), 1)  # stiffness of r_xy is tiny beside that of r
ROUNDING = 1e-9  # relative; condition of the equilibrated test matrices times machine epsilon is below 1e-11


def plate_like(nx: int, ny: int, seed: int = 0) -> Floats:
    """Dense SPD matrix with the pattern of a plate of nx by ny nodes with 12 coordinates each."""
    rng = np.random.default_rng(seed)
    k = np.zeros((12 * nx * ny, 12 * nx * ny))
    for j in range(ny - 1):
        for i in range(nx - 1):
            nodes = j * nx + i + np.array([0, 1, nx, nx + 1])
            coords = (12 * nodes[:, None] + np.arange(12)).ravel()
            b = rng.standard_normal((48, 48))
            k[np.ix_(coords, coords)] += b @ b.T + np.eye(48)
    scale = np.tile(UNITS, nx * ny)
    return scale[:, None] * k * scale


def pattern_of(k: Floats, j: Floats | None = None, symmetric: bool = True) -> tuple[Pattern, Floats, Floats]:
    """Pattern and values of dense matrices; the diagonal is always in the pattern."""
    n = len(k)
    j = np.zeros((0, n)) if j is None else j
    mask = (k != 0) | np.eye(n, dtype=bool)
    rows, cols = np.nonzero(np.triu(mask) if symmetric else mask)
    j_rows, j_cols = np.nonzero(j)
    j_indptr = np.searchsorted(j_rows, np.arange(len(j) + 1))
    indptr = np.searchsorted(rows, np.arange(n + 1))
    return Pattern(n, indptr, cols, symmetric, len(j), j_indptr, j_cols), k[rows, cols], j[j_rows, j_cols]


def check(k: Floats, j: Floats | None, method: Method, symmetric: bool = True) -> LinearSolver:
    """Solve and compare with the dense solution in equilibrated coordinates."""
    pattern, k_values, j_values = pattern_of(k, j, symmetric)
    solver = linear_solver(pattern, method)
    solver.factorise(k_values, j_values)
    rng = np.random.default_rng(1)
    n, m = pattern.n, pattern.n_lam
    dense = np.zeros((n + m, n + m))
    dense[:n, :n] = k
    if j is not None:
        dense[n:, :n], dense[:n, n:] = j, j.T
    weight = 1 / np.sqrt(np.abs(dense).max(axis=0))
    for _ in range(2):  # a second right-hand side with the same factors
        rhs = rng.standard_normal(n + m) / weight
        expected = np.linalg.solve(weight[:, None] * dense * weight, weight * rhs)
        kept = rhs.copy()
        x, y = solver.solve(rhs[:n], rhs[n:])
        assert x.shape == (n,)
        assert y.shape == (m,)
        np.testing.assert_array_equal(rhs, kept)
        assert np.abs(np.concatenate([x, y]) / weight - expected).max() < ROUNDING * np.abs(expected).max()
    return solver


@pytest.mark.parametrize("negative", [0, 3])
@pytest.mark.parametrize("symmetric", [True, False])
def test_a_front_of_several_blocks_of_columns(negative: int, symmetric: bool) -> None:
    n = 250  # one front: pivots in two whole blocks and a part of one
    rng = np.random.default_rng(2)
    b = rng.standard_normal((n, n))
    k = b @ b.T + n * np.eye(n) + (0.0 if symmetric else 0.1) * (b - b.T)
    k[:negative] *= -1.0
    k[:, :negative] *= -1.0
    k[range(negative), range(negative)] -= 4.0 * n
    check(k, None, "multifrontal", symmetric)


def constraints(n: int, m: int, seed: int = 3) -> Floats:
    """Jacobian of m constraints, each on four coordinates."""
    rng = np.random.default_rng(seed)
    j = np.zeros((m, n))
    for row in j:
        row[rng.choice(n, 4, replace=False)] = rng.standard_normal(4)
    return j


def indefinite(nx: int, ny: int) -> Floats:
    """A plate-like matrix with three negative eigenvalues."""
    k = plate_like(nx, ny)
    for index in (5, 30, 77):
        k[index, index] *= -1
    return k


PARDISO = pytest.param("pardiso", marks=pytest.mark.skipif(library() is None, reason="the package mkl is not installed"))
GENERAL_METHODS = ("auto", "superlu", PARDISO)
UNSYMMETRIC_METHODS = ("multifrontal", *GENERAL_METHODS)
INDEFINITE_METHODS = ("multifrontal", *GENERAL_METHODS)
DEFINITE_METHODS = ("band", *INDEFINITE_METHODS)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
@pytest.mark.parametrize("shape", [(2, 2), (4, 6), (7, 7), (12, 2)])
def test_positive_definite(method: Method, shape: tuple[int, int]) -> None:
    solver = check(plate_like(*shape), None, method)
    assert solver.negative_pivots in ((0, None) if method == "superlu" else (0,))


@pytest.mark.parametrize("method", DEFINITE_METHODS)
@pytest.mark.parametrize("n", [1, 2, 13])
def test_small_full_matrix(method: Method, n: int) -> None:
    b = np.random.default_rng(n).standard_normal((n, n))
    check(b @ b.T + np.eye(n), None, method)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_random_sparse_without_node_blocks(method: Method) -> None:
    b = sparse.random_array((150, 150), density=0.02, rng=np.random.default_rng(4)).toarray()
    check(b @ b.T + np.eye(150), None, method)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_clamped_plate(method: Method) -> None:
    """Eliminating a clamp leaves nodes with fewer coordinates."""
    k = plate_like(4, 4)
    held = np.r_[0:6, 48:54, 99, 120:123]
    free = np.setdiff1d(np.arange(len(k)), held)
    check(k[np.ix_(free, free)], None, method)


@pytest.mark.parametrize("method", INDEFINITE_METHODS)
def test_indefinite(method: Method) -> None:
    k = indefinite(4, 4)
    solver = check(k, None, method)
    expected = np.count_nonzero(np.linalg.eigvalsh(k) < 0)
    assert expected > 0
    assert solver.negative_pivots in (expected, None)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
@pytest.mark.parametrize("m", [1, 7])
def test_saddle_with_definite_stiffness(method: Method, m: int) -> None:
    k = plate_like(3, 4)
    check(k, constraints(len(k), m), method)


@pytest.mark.parametrize("method", INDEFINITE_METHODS)
def test_saddle_with_indefinite_stiffness(method: Method) -> None:
    k = indefinite(3, 4)
    check(k, constraints(len(k), 7), method)


@pytest.mark.parametrize("method", GENERAL_METHODS)
def test_saddle_with_singular_stiffness_held_by_constraints(method: Method) -> None:
    k = np.diag([2.0, 0.0, 3.0])
    solver = check(k, np.array([[0.0, 1.0, 1.0]]), method)
    assert solver.negative_pivots in (0, None)


@pytest.mark.parametrize("method", UNSYMMETRIC_METHODS)
@pytest.mark.parametrize("m", [0, 5, 40])
def test_unsymmetric(method: Method, m: int) -> None:
    k = plate_like(3, 4)
    k *= 1 + 0.2 * np.random.default_rng(6).standard_normal(k.shape)
    solver = check(k, constraints(len(k), m) if m else None, method, symmetric=False)
    assert solver.negative_pivots is None
    assert not isinstance(solver, AutomaticSolver) or solver.n_general == 0


@pytest.mark.parametrize("method", UNSYMMETRIC_METHODS)
@pytest.mark.parametrize(
    "one_way", [(slice(0, 12), slice(36, 72)), (slice(36, 72), slice(0, 12)), (slice(60, 144), slice(0, 60))]
)
def test_unsymmetric_in_structure(method: Method, one_way: tuple[slice, slice]) -> None:
    """Some coordinates act on others that do not act on them, as temperatures do on a shape; constraints hold some of both."""
    k = plate_like(3, 4)
    k *= 1 + 0.2 * np.random.default_rng(6).standard_normal(k.shape)
    k[one_way] = 0.0
    j = np.zeros((4, len(k)))
    j[:2, [2, 40, 61, 100]] = np.random.default_rng(7).standard_normal((2, 4))
    j[2:, 48:54] = np.random.default_rng(8).standard_normal((2, 6))
    check(k, j, method, symmetric=False)


@pytest.mark.parametrize("rest", [0.0, 1e-28])
def test_unsymmetric_with_coordinates_that_constraints_alone_determine(rest: float) -> None:
    """Six coordinates of one node without stiffness, or with one that is rounding, in six constraints that hold four others
    as well; and two coordinates of another node held by two constraints."""
    k = plate_like(3, 2)
    k *= 1 + 0.2 * np.random.default_rng(6).standard_normal(k.shape)
    k[12:18], k[:, 12:18] = 0.0, 0.0
    k[range(12, 18), range(12, 18)] = rest
    j = np.zeros((8, len(k)))
    j[:6, 40:44] = np.random.default_rng(8).standard_normal((6, 4))
    j[:6, 12:18] = np.random.default_rng(7).standard_normal((6, 6))
    j[6:, 30:32] = [[1.0, 2.0], [-1.0, 1.0]]
    check(k, j, "multifrontal", symmetric=False)


def test_many_multipliers_of_a_stiffness_that_they_make_definite() -> None:
    """K has zeros on its diagonal, which the general solver alone could take; on the null space of J it is definite."""
    k = plate_like(2, 3)
    k[:3], k[:, :3] = 0.0, 0.0
    solver = check(k, np.vstack([np.eye(len(k))[:3], constraints(len(k), 40)]), "auto")
    assert isinstance(solver, AutomaticSolver)
    assert (solver.n_general, solver.negative_pivots) == (0, 0)


def test_negative_pivots_on_the_constraint_manifold() -> None:
    """K has one negative eigenvalue, which the constraint holds; without the constraint it counts."""
    k = np.diag([2.0, -1.0, 3.0])
    assert check(k, None, "superlu").negative_pivots == 1
    assert check(k, np.array([[0.0, 1.0, 0.0]]), "superlu").negative_pivots in (0, None)


def test_automatic_needs_superlu_only_where_pivots_on_the_diagonal_fail() -> None:
    """Zeros on the diagonal of a regular matrix; the next, definite one is factorised by fronts again."""
    good = plate_like(4, 4)
    bad = good.copy()
    bad[[0, 1], [0, 1]] = 0
    pattern, good_values, none = pattern_of(good)
    solver = linear_solver(pattern)
    assert isinstance(solver, AutomaticSolver)
    for values, count in ((good_values, 0), (pattern_of(bad)[1], 1), (good_values, 1)):
        solver.factorise(values, none)
        assert solver.n_general == count
    assert solver.negative_pivots == 0


def test_inaccurate_pivots_are_not_used() -> None:
    """A tiny pivot on the diagonal of a well-conditioned matrix spoils the factors; the check sees it."""
    k = np.array([[1e-13, 1.0, 0.0], [1.0, 1e-13, 1.0], [0.0, 1.0, 3.0]])
    solver = check(k, None, "auto")
    assert isinstance(solver, AutomaticSolver)
    assert solver.n_general == 1


class Inexact(Multifrontal):
    """A factorisation whose solutions are off by a share."""

    off = 0.0

    def solve(self, r: Floats) -> Floats:
        return (1.0 + self.off) * super().solve(r)


@pytest.mark.parametrize(("off", "usable"), [(5e-11, True), (1e-9, False)])
def test_each_factorisation_is_checked_and_solutions_of_a_poor_one_are_refined(off: float, usable: bool) -> None:
    """Of a definite matrix too, whose pivots tell nothing. A refinement leaves the square of the share."""
    k = plate_like(3, 3)
    pattern, values, none = pattern_of(k)
    factor = Inexact(pattern)
    solver, r = SchurSolver(factor), np.sqrt(k.diagonal())
    solver.factorise(values, none)
    exact, _ = solver.solve(r, none)
    factor.off = off
    if not usable:
        with pytest.raises(SingularSystemError, match="no usable pivot"):
            solver.factorise(values, none)
        return
    solver.factorise(values, none)
    found, _ = solver.solve(r, none)
    assert np.abs(found / exact - 1.0).max() < 0.1 * off


@pytest.mark.parametrize(("left", "by_general"), [(1e-9, 0), (1e-13, 1)])
def test_pivots_that_may_be_rounding_are_left_to_the_general_solver(left: float, by_general: int) -> None:
    """Two coordinates that differ by a small share: the second pivot is that share of its diagonal, and the matrix is regular."""
    k = np.array([[1.0, 1.0], [1.0, 1.0 + left]])
    pattern, values, none = pattern_of(k)
    solver = linear_solver(pattern)
    assert isinstance(solver, AutomaticSolver)
    solver.factorise(values, none)
    assert solver.n_general == by_general
    found, _ = solver.solve(k @ np.array([0.0, 1.0]), none)
    assert found[1] == pytest.approx(1.0, rel=1e-15 / left)  # rounding by the condition


@pytest.mark.parametrize("method", ["multifrontal", "auto"])
def test_free_coordinate_of_an_unsymmetric_matrix_is_named(method: Method) -> None:
    """Behind a group of constraints whose coordinates lie far apart, so that motions and coordinates have different numbers."""
    k = plate_like(3, 4)
    k *= 1 + 0.2 * np.random.default_rng(6).standard_normal(k.shape)
    n, free = len(k), 50
    k[free], k[:, free] = 0.0, 0.0
    j = np.zeros((2, n))
    j[0, [2, n - 1]], j[1, [3, 4, n - 1]] = 1.0, 1.0
    pattern, k_values, j_values = pattern_of(k, j, symmetric=False)
    with pytest.raises(SingularSystemError) as raised:
        linear_solver(pattern, method).factorise(k_values, j_values)
    assert raised.value.index == free


def test_inaccurate_pivots_of_an_unsymmetric_matrix_are_not_used() -> None:
    """A regular matrix that needs an exchange of rows: refused by fronts, taken by the general solver."""
    k = np.array([[1e-13, 1.0, 0.0], [0.9, 1e-13, 1.0], [0.0, 1.0, 3.0]])
    solver = check(k, None, "auto", symmetric=False)
    assert isinstance(solver, AutomaticSolver)
    assert solver.n_general == 1
    pattern, values, none = pattern_of(k, None, symmetric=False)
    with pytest.raises(SingularSystemError, match="no usable pivot"):
        linear_solver(pattern, "multifrontal").factorise(values, none)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_free_coordinate_is_named(method: Method) -> None:
    k = plate_like(3, 3)
    k[41, :] = k[:, 41] = 0
    pattern, values, none = pattern_of(k)
    with pytest.raises(SingularSystemError, match="coordinate 41 of 108") as caught:
        linear_solver(pattern, method).factorise(values, none)
    assert caught.value.index == 41


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_free_mechanism_is_named(method: Method) -> None:
    """A chain of springs with nothing held: rounding alone decides the last pivot."""
    stiffness = np.array([0.1, 0.7, 1.3, 2.9])
    k = np.zeros((8, 8))
    for i, c in enumerate(stiffness):
        k[np.ix_([i, i + 1], [i, i + 1])] += c * np.array([[1, -1], [-1, 1]])
    k[5:, 5:] = np.diag([1.0, 2.0, 3.0])
    pattern, values, none = pattern_of(k)
    with pytest.raises(SingularSystemError) as caught:
        linear_solver(pattern, method).factorise(values, none)
    assert caught.value.index in range(5)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_floating_plate_is_singular(method: Method) -> None:
    """Three rigid translations, through element matrices that know them only to rounding."""
    k = plate_like(4, 4)
    t = np.zeros((len(k), 3))
    for c in range(3):
        t[c::12, c] = 1
    d = np.sqrt(np.diag(k))
    t, _ = np.linalg.qr(d[:, None] * t)
    scaled = k / d / d[:, None]
    full = np.eye(len(k)) - t @ t.T
    pattern, values, none = pattern_of(full @ scaled @ full)
    with pytest.raises(SingularSystemError) as caught:
        linear_solver(pattern, method).factorise(values, none)
    assert caught.value.index is not None


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_redundant_constraint_is_named(method: Method) -> None:
    k = plate_like(3, 3)
    j = constraints(len(k), 4)
    j[3] = 2 * j[1]
    pattern, k_values, j_values = pattern_of(k, j)
    with pytest.raises(SingularSystemError, match="redundant") as caught:
        linear_solver(pattern, method).factorise(k_values, j_values)
    assert caught.value.index in (len(k) + 1, len(k) + 3)


@pytest.mark.parametrize("method", DEFINITE_METHODS)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_not_finite(method: Method, bad: float) -> None:
    pattern, values, none = pattern_of(plate_like(3, 3))
    values[pattern.indptr[50]] = bad
    with pytest.raises(SingularSystemError, match="not finite") as caught:
        linear_solver(pattern, method).factorise(values, none)
    assert caught.value.index == 50


@pytest.mark.parametrize("method", DEFINITE_METHODS)
def test_no_solution_after_an_error(method: Method) -> None:
    pattern, values, none = pattern_of(plate_like(2, 2))
    solver = linear_solver(pattern, method)
    with pytest.raises(SingularSystemError):
        solver.factorise(0 * values, none)
    with pytest.raises(SingularSystemError, match="no factorisation"):
        solver.solve(np.ones(pattern.n), none)


def test_band_refuses_an_indefinite_matrix() -> None:
    pattern, values, none = pattern_of(indefinite(3, 3))
    with pytest.raises(SingularSystemError):
        linear_solver(pattern, "band").factorise(values, none)


def test_unusable_choices() -> None:
    pattern, *_ = pattern_of(plate_like(2, 2), symmetric=False)
    with pytest.raises(ValueError, match="symmetric"):
        linear_solver(pattern, "band")
    with pytest.raises(ValueError, match="choose one of"):
        linear_solver(pattern, "cramer")  # pyright: ignore[reportArgumentType]


def test_pattern_refuses_the_lower_triangle() -> None:
    with pytest.raises(ValueError, match="below the diagonal"):
        Pattern(2, np.array([0, 1, 3]), np.array([0, 0, 1]), True, 0, np.array([0]), np.zeros(0, np.int64))


def test_auto_takes_large_unsymmetric_and_saddle_matrices() -> None:
    """Sizes at which PARDISO is used when it is installed; 120 constraints that hang together have no short null space."""
    k = plate_like(5, 6)
    assert not isinstance(check(k, constraints(len(k), 120), "auto"), AutomaticSolver)
    check(k * (1 + 0.1 * np.random.default_rng(8).standard_normal(k.shape)), None, "auto", symmetric=False)


@pytest.mark.skipif(library() is not None, reason="the package mkl is installed")
def test_pardiso_without_mkl_says_how_to_install_it() -> None:
    with pytest.raises(MissingExtraError, match=r"pip install 'lamella\[mkl\]'"):
        linear_solver(pattern_of(plate_like(2, 2))[0], "pardiso")
