# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What there is to tell of an option of a bake, for all who offer, check, store or explain it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, NamedTuple

from .forms import FormTraits
from .kinds import KindTraits


class Fold(StrEnum):
    """Where the panel shows options."""

    MAIN = "Always shown"
    LIGHT = "Light"
    SURFACE = "Surface"
    SAMPLING = "Sampling"
    OUTPUT = "Output"
    SCRIPTS = "For scripts alone"


class Mark(NamedTuple):
    """What sidecars say of a bake by a key of the option's name, which is there, and true, if it was on.

    `on`, `off`: how messages tell the two apart where one is to be added to the other; `unlike`: why a bake
    that has the mark is not compared with the scene, empty if it is.
    """

    on: str
    off: str
    unlike: str = ""


@dataclass(frozen=True)
class Option:
    """One option: a row of the table `options`.

    * `name`: of the field of `BakeSpec` with its `default`, or of an option that only the request has.
    * On the command line: `flag`, `help` and `metavar`; `takes`: an enum, or int, where the default does not
      tell; `many`: may be given several times; `cli_default`: the default there, if another; `default_words`:
      the default in words, behind the help.
    * In the panel: `title`, `tooltip`, and the `fold` it is in, if not its section's; `panel_name`: the
      property's name in .blend files and scripts, if another; `items` of a menu; `panel_default`: the default
      there, if another; `blender`: more arguments of Blender's property; `hooks`: the names of its callbacks,
      which are in ui/settings/bake_settings.py; `preset`: whether presets store it.
    * `limits`: the least and the most of a whole number; `word`: its name in messages about its value.
    * `called`: its name in remedies; `label`: the panel's, if not `title`.
    * `applies`: whether a bake of that kind and form can have it; the panel leaves it out otherwise.
      `refusal`: why not, where {kind} and {value} are filled in; `instead`: what to bake then. `no_farm`: why
      a farm cannot have it.
    * `resumes`: an unfinished bake may be resumed with another value. `of_atlas`: another value makes other
      pixels, so that fingerprints have it. `added`: it came after 0.1.0; fingerprints leave its default out,
      so that bakes made before do not count as changed.
    * `mark`: for an option that is on or off, what sidecars tell of it.
    """

    name: str
    default: Any = None
    flag: str = ""
    help: str = ""
    metavar: str | None = None
    takes: type | None = None
    many: bool = False
    cli_default: Any = ...
    default_words: str = ""
    title: str = ""
    tooltip: str = ""
    fold: Fold | None = None
    panel_name: str = ""
    items: tuple[Any, ...] = ()
    panel_default: Any = ...
    blender: Mapping[str, Any] = field(default_factory=dict)
    hooks: Mapping[str, str] = field(default_factory=dict)
    preset: bool = False
    limits: tuple[int, int] | None = None
    word: str = ""
    called: str = ""
    label: str = ""
    applies: Callable[[KindTraits, FormTraits], bool] = lambda _, __: True
    refusal: str = ""
    instead: str = ""
    no_farm: str = ""
    resumes: bool = False
    of_atlas: bool = True
    added: bool = False
    mark: Mark | None = None

    @property
    def choices(self) -> type[StrEnum] | None:
        """The enum that it takes, if it does."""
        return self.takes if self.takes is not None and issubclass(self.takes, StrEnum) else None

    @property
    def setting(self) -> str:
        """The name of its property in the panel."""
        return self.panel_name or self.name

    @property
    def setting_default(self) -> Any:
        """The default in the panel: text where None is the field's."""
        known = self.default if self.panel_default is ... else self.panel_default
        return "" if known is None else str(known) if isinstance(known, StrEnum) else known

    @property
    def flag_default(self) -> Any:
        """The default on the command line."""
        return self.default if self.cli_default is ... else self.cli_default


class Section(NamedTuple):
    """Options that stand together on the command line; most of them are in one `fold` of the panel."""

    fold: Fold
    options: tuple[Option, ...]
