"""A linear model in first-order form, what can be asked of it, and how it is kept."""

from __future__ import annotations

import reprlib
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from lamella.arguments import WHOLE, accepts, numbers
from lamella.errors import DeclarationError, MissingExtraError, ModelError, ResultFileError
from lamella.linear.balanced import balanced_truncation
from lamella.linear.marginal import marginal
from lamella.roles import Floats
from lamella.whole import replaced

Complexes = NDArray[np.complex128]

MATRICES = ("A", "B", "C", "D", "input_values", "output_values")
NAMES = ("inputs", "outputs", "input_units", "output_units")


@dataclass(frozen=True)
class StateSpace:
    """x' = A x + B u, y = C x + D u for changes u and y from a steady state.

    Args:
        A, B, C, D: the matrices, shapes (n, n), (n, m), (p, n), (p, m).
        inputs, outputs: their names.
        input_units, output_units: their units.
        input_values, output_values: values in the steady state, to which u and y are added.
        error_bound: largest error of the transfer matrix of a reduced model at any frequency, in its largest singular value,
            compared with the model that was reduced; None where nothing was truncated by balancing.
        hankel: Hankel singular values of the stable part that was balanced, descending.
    """

    A: Floats
    B: Floats
    C: Floats
    D: Floats
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    input_units: tuple[str, ...]
    output_units: tuple[str, ...]
    input_values: Floats
    output_values: Floats
    error_bound: float | None = None
    hankel: Floats | None = None

    @property
    def n_states(self) -> int:
        """Number of states."""
        return len(self.A)

    def poles(self) -> Complexes:
        """Eigenvalues of A by size [1/s], shape (n,)."""
        found = np.asarray(linalg.eigvals(self.A), complex)
        return found[np.argsort(np.abs(found), kind="stable")]

    @property
    def is_stable(self) -> bool:
        """Whether all poles lie to the left of the imaginary axis."""
        return not marginal(self.A)[1].any()

    def dc_gain(self) -> Floats:
        """Steady outputs for constant inputs, D - C A^-1 B, shape (p, m).

        Raises:
            ModelError: there are none: a rigid-body motion or another pole at zero.
        """
        if marginal(self.A)[2].any():
            raise ModelError("dc_gain: the model has a pole at zero, a constant input gives no steady output")
        return self.D - self.C @ np.linalg.solve(self.A, self.B)

    @accepts(frequencies=numbers("a list of frequencies [Hz]"))
    def frequency_response(self, frequencies: Floats) -> Complexes:
        """Transfer matrix C (i 2 pi f - A)^-1 B + D at frequencies [Hz], shape (n_f, p, m).

        Raises:
            ModelError: a pole lies at one of the frequencies.
        """
        at = np.asarray(frequencies, float)
        if not len(at) or not np.isfinite(at).all():
            given = f"frequencies = {reprlib.repr(at.tolist())}"
            raise DeclarationError("frequency_response", given, "accepted is at least one, and finite ones")
        found, one, B = [], np.eye(self.n_states), self.B.astype(complex)
        for f in at:
            try:
                found.append(self.C @ np.linalg.solve(2j * np.pi * f * one - self.A, B) + self.D)
            except np.linalg.LinAlgError as error:
                raise ModelError(f"frequency_response: at {f:g} Hz is a pole; accepted are other frequencies") from error
        return np.stack(found)

    def response(self, t: Floats, u: Floats) -> Floats:
        """Outputs from rest for inputs that are linear between equally spaced times; exact for these.

        Args:
            t: times [s], equally spaced, shape (n_t,).
            u: inputs, shape (n_t, m).

        Returns:
            Changes of the outputs, shape (n_t, p).
        """
        t, u = _floats("response", "times", t), _floats("response", "inputs", u)
        if t.ndim != 1 or len(t) < 2 or not (t[1] > t[0] and np.allclose(np.diff(t), t[1] - t[0], rtol=1e-6, atol=0.0)):
            given = f"times {reprlib.repr(t.tolist())}"
            raise DeclarationError("response", given, "accepted are at least two, ascending and equally spaced")
        if u.shape != (len(t), len(self.inputs)):
            raise DeclarationError(
                "response", f"inputs of shape {u.shape}", f"accepted are {len(self.inputs)} for each of {len(t)} times"
            )
        if not np.isfinite(u).all():
            raise DeclarationError("response", f"inputs = {reprlib.repr(u.tolist())}", "accepted are finite numbers")
        n, m, dt = self.n_states, len(self.inputs), t[1] - t[0]
        whole = np.zeros((n + 2 * m, n + 2 * m))
        whole[:n, :n], whole[:n, n : n + m], whole[n : n + m, n + m :] = dt * self.A, dt * self.B, np.eye(m)
        moved = linalg.expm(whole)[:n]
        x, out = np.zeros(n), np.empty((len(t), len(self.outputs)))
        for k in range(len(t)):
            out[k] = self.C @ x + self.D @ u[k]
            if k + 1 < len(t):
                x = moved @ np.concatenate([x, u[k], u[k + 1] - u[k]])
        return out

    def step_response(self, t: Floats, name: str) -> Floats:
        """Changes of the outputs after a unit step of one input, at equally spaced times [s], shape (n_t, p)."""
        t = _floats("step_response", "times", t)
        u = np.zeros((t.size, len(self.inputs)))
        u[:, self._number(name, self.inputs, "input")] = 1.0
        return self.response(t, u)

    @accepts(order=WHOLE)
    def balanced(self, order: int) -> StateSpace:
        """The model with ``order`` states that balanced truncation leaves; poles that are not stable are all kept.

        There are fewer where no more are both reached by the inputs and seen in the outputs, as those of a plate that twists
        under a force at its middle: their Hankel singular values are rounding.

        The error bound is that of the transfer matrix as it stands, in the units of its inputs and outputs: scale them first
        (``scaled``) where they differ by orders of magnitude.

        Raises:
            DeclarationError: the order is not possible.
            ModelError: more poles are not stable than there shall be states.
        """
        poles, kept, _ = marginal(self.A)
        unstable = int(np.sum(poles.real >= poles.real[kept].min(initial=np.inf)))
        if not 1 <= order <= self.n_states:
            raise DeclarationError("balanced", f"order = {order}", f"accepted is 1 to {self.n_states}")
        if unstable > order:
            raise ModelError(
                f"balanced: {unstable} of {self.n_states} poles are not stable (rigid-body motions, undamped or growing "
                f"vibrations) and are kept as they are, which is more than order = {order}; accepted is a larger order, or "
                "damping, so that vibrations decay"
            )
        A, B, C, hankel, bound = balanced_truncation(self.A, self.B, self.C, order, unstable)
        return replace(self, A=A, B=B, C=C, hankel=hankel, error_bound=bound + (self.error_bound or 0.0))

    def scaled(self, inputs: Floats, outputs: Floats) -> StateSpace:
        """The same model with inputs and outputs counted in other sizes: u / inputs and y / outputs, both with unit 1."""
        by, of = _floats("scaled", "inputs", inputs), _floats("scaled", "outputs", outputs)
        for sizes, names, kind in ((by, self.inputs, "inputs"), (of, self.outputs, "outputs")):
            if sizes.shape != (len(names),) or not np.all((sizes > 0.0) & np.isfinite(sizes)):
                given = f"{kind} = {reprlib.repr(sizes.tolist())}"
                raise DeclarationError("scaled", given, f"accepted is a positive one for each of {', '.join(names)}")
        return replace(
            self,
            B=self.B * by,
            C=self.C / of[:, None],
            D=self.D * by / of[:, None],
            input_units=("1",) * len(by),
            output_units=("1",) * len(of),
            input_values=self.input_values / by,
            output_values=self.output_values / of,
            error_bound=None,
        )

    def to_control(self) -> Any:
        """The model as a StateSpace of python-control, with the names of inputs and outputs; a dot in a name becomes ``_``.

        Raises:
            MissingExtraError: python-control is not installed.
        """
        try:
            control = import_module("control")
        except ImportError as error:
            raise MissingExtraError("to_control needs python-control; install it with: pip install 'lamella[control]'") from error
        names = {key: [name.replace(".", "_") for name in getattr(self, key)] for key in ("inputs", "outputs")}
        return control.ss(self.A, self.B, self.C, self.D, **names)

    def save(self, path: str | Path) -> Path:
        """Write all matrices, names, units and values of the steady state, as ``.npz`` (NumPy) or ``.mat`` (MATLAB, Octave).

        Raises:
            ResultFileError: another suffix, or the file cannot be written.
        """
        path, data = Path(path), self._data()
        if path.suffix not in (".npz", ".mat"):
            raise ResultFileError(f"linear model '{path}': unknown suffix '{path.suffix}'; accepted are .npz and .mat")
        with replaced(path) as partial, partial.open("wb") as file:  # savemat's own errors of opening a file say nothing
            if path.suffix == ".npz":
                np.savez(file, allow_pickle=False, **{key: np.asarray(value) for key, value in data.items()})
            else:
                from scipy.io import savemat

                texts = {key: np.array(value, dtype=object) if key in NAMES else value for key, value in data.items()}
                savemat(file, texts, oned_as="column")
        return path

    @classmethod
    def load(cls, path: str | Path) -> StateSpace:
        """Read a model that was saved as ``.npz``.

        Raises:
            ResultFileError: there is no such file, or it holds no linear model.
        """
        try:
            with np.load(path, allow_pickle=False) as file:
                data: dict[str, Any] = {key: file[key] for key in MATRICES}
                data |= {key: tuple(file[key].tolist()) for key in NAMES}
                bound = float(file["error_bound"])
                data["hankel"] = file["hankel"] if len(file["hankel"]) else None
        except OSError as error:
            raise ResultFileError(
                f"'{path}' cannot be read: {error.strerror or error}; accepted is a .npz that save wrote"
            ) from error
        except (EOFError, KeyError, TypeError, ValueError, BadZipFile) as error:  # an array alone has no names
            raise ResultFileError(f"'{path}' is no linear model; accepted is a .npz that save wrote") from error
        return cls(**data, error_bound=None if np.isnan(bound) else bound)

    def _data(self) -> dict[str, Any]:
        data: dict[str, Any] = {key: getattr(self, key) for key in (*MATRICES, *NAMES)}
        data["error_bound"] = np.nan if self.error_bound is None else self.error_bound
        data["hankel"] = np.zeros(0) if self.hankel is None else self.hankel
        return data

    @staticmethod
    def _number(name: str, known: tuple[str, ...], kind: str) -> int:
        if name not in known:
            raise DeclarationError("StateSpace", f"there is no {kind} '{name}'", f"accepted are {', '.join(known)}")
        return known.index(name)


def _floats(item: str, name: str, value: Any) -> Floats:
    """An argument as an array of numbers.

    Raises:
        DeclarationError: it is none; the message begins with ``item``.
    """
    try:
        return np.asarray(value, float)
    except (TypeError, ValueError) as error:
        raise DeclarationError(item, f"{name} = {reprlib.repr(value)}", "accepted is a list of numbers") from error
