"""Modules under the original's names: how they are found, what they refuse, what they hide."""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from engram._args.values import nearest
from engram.errors import BadStateError
from engram.mikasa._original_names import PACKAGES, SOURCES, reason

FORCE = "ENGRAM_MIKASA_FORCE"  # the environment variable
_PATH = "PYTHONPATH"
# Child processes find packages here that import engram.mikasa.alias.
_FOR_CHILDREN = str(Path(__file__).with_name("_original_packages"))
_MOST = 30  # names in a message
PACKAGES_TEXT = ", ".join(PACKAGES[:-1]) + f" and {PACKAGES[-1]}"


class AliasModule(ModuleType):
    """A module of the original's name. Attributes are those of engram's, also when they are set."""

    def __getattr__(self, name: str) -> Any:
        source = SOURCES[self.__name__]
        if name == "__all__":
            return list(source.offered())
        if name.startswith("__"):
            raise AttributeError(f"{self.__name__}, of engram.mikasa, has no {name}")
        module = f"{self.__name__}.{name}"
        if module in SOURCES:
            return importlib.import_module(module)
        if source.module and name in (source.names or (name,)):
            target = importlib.import_module(source.module)
            if hasattr(target, name):
                return getattr(target, name)
        raise AttributeError(_refusal(self.__name__, name))

    def __setattr__(self, name: str, value: Any) -> None:
        if self._is_own(name, value):
            super().__setattr__(name, value)
        else:
            setattr(importlib.import_module(SOURCES[self.__name__].module), name, value)

    def __delattr__(self, name: str) -> None:
        if self._is_own(name):
            super().__delattr__(name)
        else:
            delattr(importlib.import_module(SOURCES[self.__name__].module), name)

    def __dir__(self) -> list[str]:
        return sorted({*vars(self), *_offered(self.__name__)})

    def _is_own(self, name: str, value: Any = None) -> bool:
        """True for what the import machinery sets, and where there is no module of engram's."""
        return (
            name.startswith("__")
            or isinstance(value, AliasModule)
            or name in vars(self)
            or not SOURCES[self.__name__].module
        )


def _offered(module: str) -> list[str]:
    """Names of a module, with those of the modules below it."""
    split = [name.rpartition(".") for name in SOURCES]
    below = {name for parent, _, name in split if parent == module}
    return sorted({*SOURCES[module].offered(), *below})


def _refusal(module: str, name: str) -> str:
    """The sentence about a name that a module lacks, or a module that a package lacks."""
    full = f"{module}.{name}"
    why = reason(full)
    offered = _offered(module)
    by_letters = {one.lower(): one for one in offered}
    meant = by_letters.get(nearest(name.lower(), by_letters) or "")
    listed = ", ".join(offered) or "nothing"
    if len(offered) > _MOST:
        listed = f"{len(offered)} names, {offered[0]} to {offered[-1]}, which dir() lists"
    return (
        f"{full}: engram.mikasa, which stands in for {PACKAGES_TEXT}, has no such name"
        + (f", because {why}" if why else "")
        + f"; of {module} it has {listed}"
        + (f". Did you mean {meant}?" if meant else "")
    )


class _Finder(MetaPathFinder, Loader):
    """Finds the original's packages in engram.

    Args:
        force: True: installed packages of these names are hidden.
    """

    def __init__(self, force: bool) -> None:
        self.force = force

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, below = fullname.partition(".")
        if package not in PACKAGES:
            return None
        if not below and not self.force:  # the program may have added a folder to sys.path
            found = _installed(package)
            if found is not None:
                raise ImportError(_would_hide({package: found}), name=package)
        if fullname not in SOURCES:
            # Without its name: `from package import name` would replace the sentence.
            parent, _, name = fullname.rpartition(".")
            raise ModuleNotFoundError(_refusal(parent, name))
        return ModuleSpec(fullname, self, origin="engram.mikasa", is_package=True)

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return AliasModule(spec.name, f"engram.mikasa's part of the original's {spec.name}.")

    def exec_module(self, module: ModuleType) -> None:
        source = SOURCES[module.__name__].module
        if source:
            importlib.import_module(source)


def _installed(package: str) -> str | None:
    """The file of another package of this name; None: there is none."""
    for finder in sys.meta_path:
        if isinstance(finder, _Finder):
            continue
        if finder is PathFinder:
            path = [folder for folder in sys.path if folder != _FOR_CHILDREN]
            spec = PathFinder.find_spec(package, path)
        else:
            spec = finder.find_spec(package, None)
        # Folders without __init__.py have no origin; packages go before them.
        if spec is not None and spec.origin is not None:
            return spec.origin
    return None


def _imported(package: str) -> ModuleType | None:
    """Another package of this name that is imported already."""
    module = sys.modules.get(package)
    if module is None or isinstance(module, AliasModule) or _is_for_children(module):
        return None
    return module


def _is_for_children(module: ModuleType) -> bool:
    return str(getattr(module, "__file__", "")).startswith(_FOR_CHILDREN + os.sep)


def _would_hide(found: dict[str, str]) -> str:
    places = ", ".join(f"{package} ({place})" for package, place in found.items())
    return (
        f"engram.mikasa.alias would hide {places}. Uninstall it, or take it off sys.path; or hide "
        f"it: python -m engram.mikasa --force PROGRAM, or {FORCE}=1 in the environment"
    )


def install(force: bool | None = None) -> None:
    """Makes the original's packages importable, backed by engram.mikasa.

    Args:
        force: True: packages of these names that are installed are hidden, with a warning. None:
            as the environment variable ENGRAM_MIKASA_FORCE says, 1 for True.

    Raises:
        BadStateError: A package of these names is installed and not to be hidden, or imported.
    """
    if force is None:
        force = os.environ.get(FORCE) == "1"
    if any(isinstance(finder, _Finder) and finder.force >= force for finder in sys.meta_path):
        return
    for package in PACKAGES:
        module = _imported(package)
        if module is not None:
            place = getattr(module, "__file__", None) or "a folder without __init__.py"
            raise BadStateError(
                f"{package} ({place}) is imported already; import engram.mikasa.alias before it"
            )
    found = {package: _installed(package) for package in PACKAGES}
    hidden = {package: place for package, place in found.items() if place is not None}
    if hidden and not force:
        raise BadStateError(_would_hide(hidden))
    _remove_finder()
    finder = _Finder(force)
    sys.meta_path.insert(0, finder)
    for package in PACKAGES:
        if package in sys.modules and _is_for_children(sys.modules[package]):
            del sys.modules[package]
            importlib.import_module(package)
    if hidden:
        places = ", ".join(f"{package} ({place})" for package, place in hidden.items())
        warnings.warn(f"engram.mikasa.alias hides {places}", stacklevel=2)


def uninstall() -> None:
    """Takes the names back: imports find installed packages again. Ids stay registered."""
    _remove_finder()
    for name, module in list(sys.modules.items()):
        if isinstance(module, AliasModule):
            del sys.modules[name]
    sys.modules.pop("engram.mikasa.alias", None)  # the next import installs them again
    sys.path[:] = [folder for folder in sys.path if folder != _FOR_CHILDREN]
    folders = os.environ.get(_PATH, "").split(os.pathsep)
    if _FOR_CHILDREN in folders:
        folders.remove(_FOR_CHILDREN)
        os.environ[_PATH] = os.pathsep.join(folders)


def install_in_children(force: bool) -> None:
    """Makes Python programs that this process starts have the names, too."""
    given = os.environ.get(_PATH)
    if _FOR_CHILDREN not in (given or "").split(os.pathsep):
        os.environ[_PATH] = os.pathsep.join([_FOR_CHILDREN, *([given] if given else [])])
    if _FOR_CHILDREN not in sys.path:  # which processes of multiprocessing inherit
        sys.path.insert(0 if force else 1, _FOR_CHILDREN)
    if force:
        os.environ[FORCE] = "1"


def _remove_finder() -> None:
    sys.meta_path[:] = [finder for finder in sys.meta_path if not isinstance(finder, _Finder)]
