# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line's reference, from its parsers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator

from radtex_addon.cli import (
    arguments,
    assemble_arguments,
    compare_arguments,
    export_arguments,
    prepare_arguments,
    report_arguments,
    work_arguments,
)

from .markdown import code, escaped, table, worded

_PARSERS: dict[str, Callable[[bool], argparse.ArgumentParser]] = {
    "bake": arguments.build_parser,
    "export": export_arguments.build_parser,
    "report": report_arguments.build_parser,
    "compare": compare_arguments.build_parser,
    "prepare": prepare_arguments.build_parser,
    "work": work_arguments.build_parser,
    "assemble": assemble_arguments.build_parser,
}


def commands(_: str) -> str:
    """A table of all commands, each with the first sentence of its description."""
    rows = []
    for name, parser in _PARSERS.items():
        told = " ".join((parser(False).description or "").split())
        rows.append((f"[{code(parser(False).prog)}](commands/{name}.md)", escaped(told.partition(". ")[0])))
    return table(("command", "what it does"), rows)


def command(name: str) -> str:
    """One command: what it does, its usage, its options in the groups of --help, and examples."""
    return "\n".join(_command(_PARSERS[name](False)))


def _command(parser: argparse.ArgumentParser) -> Iterator[str]:
    yield f"```{{program}} {parser.prog}\n```\n"
    for paragraph in (parser.description or "").split("\n\n"):
        yield f"{worded(' '.join(paragraph.split()))}\n"
    usage = parser.format_usage().removeprefix("usage:").strip().splitlines()
    yield "\n".join(["```text", *(line.strip() for line in usage), "```\n"])
    for group in parser._action_groups:  # noqa: SLF001  # argparse has no other way to them
        actions = [action for action in group._group_actions if action.help != argparse.SUPPRESS]  # noqa: SLF001  # as above
        if actions:
            yield f"## {str(group.title)[:1].upper()}{str(group.title)[1:]}\n"
            yield from (_option(parser, action) for action in actions)
    if parser.epilog:
        yield f"## Examples and exit codes\n\n```text\n{parser.epilog}\n```\n"


def _option(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    formatter = parser._get_formatter()  # noqa: SLF001  # argparse has no other way to it
    values = "" if action.nargs == 0 else formatter._format_args(action, str(action.metavar or action.dest))  # noqa: SLF001  # as above
    if not action.option_strings:
        values = str(action.metavar or action.dest)
    signature = ", ".join(f"{flag} {values}".strip() for flag in action.option_strings) or values
    told = formatter._expand_help(action) if action.help else ""  # noqa: SLF001  # as above
    return f"```{{option}} {signature}\n{_sentence(told)}\n```\n"


def _sentence(text: str) -> str:
    told = worded(text)
    return f"{told[:1].upper()}{told[1:]}{'' if told.endswith('.') else '.'}"
