"""What a run remembers as bytes: JSON, with arrays in base 64, exact to the bit."""

from __future__ import annotations

import base64
import json
from dataclasses import fields
from typing import Any

import numpy as np

from lamella.assembly.point import Point
from lamella.result import Happening
from lamella.state import State

CLASSES = {cls.__name__: cls for cls in (Point, State, Happening)}


def encoded(memory: object) -> bytes:
    """Bytes of numbers, texts, arrays, tuples, lists, dicts with texts as keys, and the few classes that hold them."""
    return json.dumps(_plain(memory)).encode()


def decoded(data: bytes) -> Any:
    """What :func:`encoded` was given.

    Raises:
        ValueError: these are no such bytes.
    """
    return _whole(json.loads(data))


def _plain(value: Any) -> Any:
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, (int, float, np.integer, np.floating)):
        return value.item() if isinstance(value, np.generic) else value
    if isinstance(value, np.ndarray):
        return {"array": base64.b64encode(value.tobytes()).decode(), "type": value.dtype.str, "shape": value.shape}
    if isinstance(value, tuple):
        return {"tuple": [_plain(item) for item in value]}
    if isinstance(value, list):
        return [_plain(item) for item in value]
    if isinstance(value, dict):
        return {"dict": {key: _plain(item) for key, item in value.items()}}
    name = type(value).__name__
    assert name in CLASSES, f"{name} cannot be remembered"
    return {"class": name, "fields": {item.name: _plain(getattr(value, item.name)) for item in fields(value)}}


def _whole(plain: Any) -> Any:
    if isinstance(plain, list):
        return [_whole(item) for item in plain]
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        flat = np.frombuffer(base64.b64decode(plain["array"]), np.dtype(plain["type"]))
        return flat.reshape(plain["shape"]).copy()
    if "tuple" in plain:
        return tuple(_whole(item) for item in plain["tuple"])
    if "dict" in plain:
        return {key: _whole(item) for key, item in plain["dict"].items()}
    if "class" in plain:
        return CLASSES[plain["class"]](**{key: _whole(item) for key, item in plain["fields"].items()})
    raise ValueError("no saved state")
