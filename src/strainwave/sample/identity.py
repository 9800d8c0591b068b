"""Identity of a sweep: a text of its system, points and measure, and the hash of it."""

import functools
import hashlib
import json
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from ..compile.bytecode import PACKAGE
from ..compile.identity import Identity


def identity(thing: Any) -> str:
    """Text that is equal for equal things in every process, and different for different ones.

    Functions have it in one version of Python, whose bytecode is part of it.

    Raises
    ------
    TypeError
        If `thing` is or holds something that has no such text.
    """
    return Identity().text(thing)


def digest(*things: Any) -> str:
    """Hash of the identity of things."""
    return hashlib.sha256(identity(things).encode(errors="surrogatepass")).hexdigest()


def installed(*things: Any) -> list[str]:
    """Names and versions of what things with an identity use: Python, where its bytecode is in it, and packages."""
    walk = Identity()
    walk.text(things)
    names = {name.partition(".")[0] for name in walk.packages} - sys.stdlib_module_names - {PACKAGE}
    python = [f"Python {sys.version_info.major}.{sys.version_info.minor}"] if walk.has_code else []
    return [*python, *(f"{name} {_version(name)}" for name in sorted(names))]


def readable(measure: Any) -> str:
    """Name of a measure for people."""
    inner = measure.func if isinstance(measure, functools.partial) else getattr(measure, "measure", None)
    if inner is not None:  # of a partial, or of the variants of a project
        return readable(inner)
    return getattr(measure, "__qualname__", None) or type(measure).__qualname__


def check_spec(path: Path, attributes: Mapping[str, Any]) -> None:
    """Refuse a folder that is no store, or that of another sweep than the one with these attributes (ValueError)."""
    try:
        stored = json.loads((path / "zarr.json").read_text(encoding="utf-8"))["attributes"]
        spec = stored["spec"]
    except (OSError, ValueError, KeyError, TypeError):
        raise ValueError(f"{path} exists and is not a store of a sweep; choose another path") from None
    if spec == attributes["spec"]:
        return
    begun, present = [
        [name for name in record.get("installed", ()) if name[:6] == "Python"] for record in (stored, attributes)
    ]
    if begun and present and begun != present:
        raise ValueError(
            f"{path} was begun with {begun[0]}, this is {present[0]}, with different functions; "
            f"finish the sweep with {begun[0]}, or choose another path"
        )
    names = [_named(path, name) for name in stored.get("parameters", ())]
    raise ValueError(
        f"{path} holds another sweep ({stored.get('measure')} over {', '.join(names)}; hash "
        f"{spec[:8]}, this one has {attributes['spec'][:8]}); choose another path, or delete it"
    )


def check_versions(path: Path, begun: Mapping[str, Any], current: Mapping[str, Any]) -> None:
    """Refuse to go on with a sweep that other versions of what is installed have begun (ValueError)."""
    versions = ([f"strainwave {of.get('strainwave')}", *of.get("installed", ())] for of in (begun, current))
    for before, now in zip(*versions, strict=False):
        if before != now:
            fault = f"{path} was begun with {before}, this is {now}; finish it with that version, or use another path"
            raise ValueError(fault)


def _named(path: Path, axis: str) -> str:
    """Name of the numbers along an axis of a store, where it has one of its own."""
    with suppress(OSError, ValueError, KeyError):
        return str(json.loads((path / axis / "zarr.json").read_text(encoding="utf-8"))["attributes"]["name"])
    return axis


def _version(name: str) -> str:
    with suppress(PackageNotFoundError):
        return version(name)
    return str(getattr(sys.modules.get(name), "__version__", "unknown"))
