# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the reference pages of the command line, the settings and the operators from the program itself.

They go into docs/reference/generated before Sphinx looks for pages, and never into the repository.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

_COMMANDS = ("bake", "export", "report", "compare", "prepare", "assemble")
_ASIDE = ("help", "for a program that runs this one")  # groups that come last, without being part of the work
_HEAD = "<!-- Written by docs/_ext/reference_pages.py from the program: changes here are lost. -->\n"


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension; called by Sphinx."""
    app.connect("builder-inited", _write_pages)
    return {"parallel_read_safe": True}


def _write_pages(app: Sphinx) -> None:
    folder = Path(app.srcdir, "reference/generated")
    folder.mkdir(exist_ok=True)
    pages: dict[str, Callable[[], Iterable[str]]] = {
        "batch.md": command_page,
        "settings.md": settings_page,
        "operators.md": operators_page,
    }
    for name, page in pages.items():
        text = "\n".join([_HEAD, *page()]) + "\n"
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:  # else Sphinx reads it anew
            path.write_text(text, encoding="utf-8")


def command_page() -> Iterator[str]:
    """The options of all commands of bake.py, as `--help` has them."""
    from radtex_addon.cli import (  # noqa: PLC0415  # they import bpy, which Sphinx's other commands need not
        arguments,
        assemble_arguments,
        compare_arguments,
        export_arguments,
        prepare_arguments,
        report_arguments,
    )

    parsers = {
        "bake": arguments.build_parser,
        "export": export_arguments.build_parser,
        "report": report_arguments.build_parser,
        "compare": compare_arguments.build_parser,
        "prepare": prepare_arguments.build_parser,
        "assemble": assemble_arguments.build_parser,
    }
    yield "# Command line\n"
    yield (
        "`uv run bake.py …` in a clone, or `blender -b SCENE -P bake.py -- …` with the extension installed. "
        "Every option is here as `--help` prints it. The [pipeline tutorial](../../tutorials/pipeline.md) shows them at work.\n"
    )
    for name in _COMMANDS:
        yield from _command(parsers[name](inside_blender=False))


def _command(parser: argparse.ArgumentParser) -> Iterator[str]:
    yield f"## {parser.prog}\n"
    yield f"```{{program}} {parser.prog}\n```\n"
    yield f"{escaped(parser.description or '')}\n"
    yield f"```text\n{parser.format_usage().removeprefix('usage: ').rstrip()}\n```\n"
    groups = [group for group in parser._action_groups if group._group_actions]
    for group in sorted(groups, key=lambda group: group.title in _ASIDE):  # a stable sort
        yield f"### {parser.prog}: {group.title}\n"
        for action in group._group_actions:
            if action.help != argparse.SUPPRESS:
                yield _option(parser, action)
    if parser.epilog:
        yield f"```text\n{parser.epilog}\n```\n"


def _option(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    values = parser._get_formatter()._format_args(action, _metavar(action)) if action.nargs != 0 else ""
    signature = ", ".join(f"{flag} {values}".strip() for flag in action.option_strings) or values
    text = parser._get_formatter()._expand_help(action) if action.help else ""
    return f"```{{option}} {signature}\n{escaped(text)}\n```\n"


def _metavar(action: argparse.Action) -> str:
    if isinstance(action.metavar, str):
        return action.metavar
    if action.choices is not None:
        return f"{{{','.join(map(str, action.choices))}}}"
    return action.dest.upper()


def settings_page() -> Iterator[str]:
    """All settings of the panel, by their names in Python."""
    from radtex_addon.ui.settings.bake_settings import RADTEX_PG_settings  # noqa: PLC0415  # imports bpy

    yield "# Settings\n"
    yield (
        "The settings of the panel. Their names in Python are what `bpy.ops.radtex.bake(…)` takes, and what "
        "`bpy.context.scene.radtex` has. The text is the setting's tooltip; [the panel's page](../../panel.md) explains "
        "the ones that you see first.\n"
    )
    with _registered():
        for prop in RADTEX_PG_settings.bl_rna.properties:
            if prop.is_runtime and prop.identifier != "name" and not prop.is_hidden and prop.name:
                yield from _setting(prop)


def operators_page() -> Iterator[str]:
    """All operators that a script may call."""
    import bpy  # noqa: PLC0415  # Sphinx's other commands need no Blender

    from radtex_addon.ui import registration  # noqa: PLC0415

    yield "# Operators\n"
    yield (
        "What the panel's buttons call, and F3 finds; a script calls the same. Without `object` an operator takes what is "
        "selected. Arguments of `bpy.ops.radtex.bake` are also all the [settings](settings.md).\n"
    )
    shared = _setting_names()
    with _registered():
        for cls in registration.CLASSES:
            if issubclass(cls, bpy.types.Operator) and "INTERNAL" not in getattr(cls, "bl_options", ()):
                yield from _operator(cls, shared)


def _operator(cls: type, shared: set[str]) -> Iterator[str]:
    import bpy  # noqa: PLC0415

    name = cls.bl_idname.partition(".")[2]  # type: ignore[attr-defined]  # an operator has one
    rna = getattr(bpy.ops.radtex, name).get_rna_type()
    yield f"## bpy.ops.radtex.{name}\n"
    yield f"**{escaped(rna.name)}.** {escaped(rna.description)}.\n"
    for prop in rna.properties:
        if prop.is_runtime and prop.identifier not in shared and not prop.is_hidden and prop.name:
            yield f"* {_said(prop)}"
    yield ""


def _setting_names() -> set[str]:
    from radtex_addon.ui.settings.bake_settings import NAMES  # noqa: PLC0415  # imports bpy

    return set(NAMES)


def _setting(prop: Any) -> Iterator[str]:
    yield f"## {escaped(prop.name)}\n"
    yield f"`{prop.identifier}`: {_kind(prop)}. {escaped(prop.description)}.\n"
    if prop.type == "ENUM" and len(prop.enum_items):
        for item in prop.enum_items:
            yield f"* **{escaped(item.name)}** (`{item.identifier!r}`): {escaped(item.description)}"
        yield ""


def _said(prop: Any) -> str:
    words = f"`{prop.identifier}`: {_kind(prop)}. {escaped(prop.description)}"
    if prop.type == "ENUM" and len(prop.enum_items):
        words += f" ({', '.join(f'`{item.identifier!r}`' for item in prop.enum_items)})"
    return words


def _kind(prop: Any) -> str:
    """The type of a property, its default and its range."""
    if prop.type == "ENUM":
        return "a set of choices" if prop.is_enum_flag else f"choice, `{prop.default!r}` by default"
    if prop.type == "POINTER":
        return "a data-block"
    if prop.type == "COLLECTION":
        return "a list"
    words = {"BOOLEAN": "yes or no", "INT": "whole number", "FLOAT": "number", "STRING": "text"}[prop.type]
    default = round(prop.default, 6) if prop.type == "FLOAT" else prop.default
    if prop.type in {"INT", "FLOAT"}:
        words += f", {_number(prop.hard_min)} to {_number(prop.hard_max)}"
    return f"{words}, `{default!r}` by default"


def _number(value: float) -> str:
    return "any" if abs(value) > 1e9 else f"{value:g}"


def _registered() -> Any:
    from tests.blender.ui_stage import registered  # noqa: PLC0415  # imports bpy

    return registered()


def escaped(text: str) -> str:
    """Plain text as MyST's Markdown."""
    return re.sub(r"([\\`*_{}\[\]<>#|$~])", r"\\\1", text.strip())
