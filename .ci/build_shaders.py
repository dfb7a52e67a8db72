# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the shaders' lookups in each language from their one text: `uv run .ci/build_shaders.py`.

shaders/source/*.c hold each lookup once; shaders/source/README.md says what they may hold. What is written
into shaders/ is committed, too: a test fails where it is not what its source makes of it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import takewhile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHADERS = ROOT / "shaders"
ENDINGS = {"glsl": "glsl", "hlsl": "hlsl", "wgsl": "wgsl", "godot": "gdshaderinc"}
WIDTH = 120

_KINDS = (("", "float", "f"), ("i", "int", "i"), ("u", "uint", "u"))
WORDS: dict[str, dict[str, str]] = {
    "glsl": {},
    "godot": {},
    "hlsl": {f"{kind}vec{n}": f"{scalar}{n}" for kind, scalar, _ in _KINDS for n in "234"},
    "wgsl": {f"{kind}vec{n}": f"vec{n}{letter}" for kind, _, letter in _KINDS for n in "234"},
}
WORDS["hlsl"] |= {
    "mat3": "float3x3",
    "sampler2D": "Texture2D",
    "sampler2DArray": "Texture2DArray",
    "textureLod": "radtex_looked_up",
    "mix": "lerp",
    "fract": "frac",
    "inversesqrt": "rsqrt",
    "dFdx": "ddx",
    "dFdy": "ddy",
}
WORDS["wgsl"] |= {
    **{scalar: f"{letter}32" for _, scalar, letter in _KINDS},
    "mat3": "mat3x3f",
    "sampler2D": "texture_2d<f32>",
    "sampler2DArray": "texture_2d_array<f32>",
    "texelFetch": "textureLoad",
    "inversesqrt": "inverseSqrt",
    "dFdx": "dpdx",
    "dFdy": "dpdy",
    "from": "whence",  # it is a reserved word
}
# Whether WGSL, which has no preprocessor, has these. Of the first two there are variants: see `Source.again`.
MACROS = {"RADTEX_PAGES": False, "RADTEX_HARDWARE_LINEAR": False, "RADTEX_SHADOW_LAYERS": True}

_NAME = re.compile(r"(?<![\w.])[A-Za-z_]\w*")
_TYPE = r"(?:const )?(?:float|int|uint|bool|[iu]?vec[234]|mat3|Radtex\w+)"
_FUNCTION = re.compile(r"(\w+) (\w+)\(([^()]*)\) \{", re.DOTALL)
_HINT = re.compile(r"\[(?:unroll|loop)\] ")  # of HLSL, before a loop
_LOOP = re.compile(r"for \(\w+ (.*?); (.*)\) \{")
_DECLARATION = re.compile(rf"({_TYPE}) (\w.*);", re.DOTALL)
_DECLARED = re.compile(r"(\w+)(?:\[(\w+)\])?(?: = (.*))?", re.DOTALL)
_ASSIGNMENT = re.compile(r"([\w.\[\]]+ [-+*/]?= |return )(.*);", re.DOTALL)
_TINY = re.compile(r"\b1e-(?:1[5-9]|[2-9]\d)\b")  # Godot passes literals on with 14 decimals


def main() -> None:
    """Write the files that differ, and print their names."""
    for path, text in rendered().items():
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8", newline="\n")
            print(path.relative_to(ROOT), flush=True)


def rendered() -> dict[Path, str]:
    """The text of every file that a source makes, by its path."""
    paths = sorted((SHADERS / "source").glob("*.c"))
    sources = {path.stem: Source(path.stem, path.read_text(encoding="utf-8")) for path in paths}
    made = {}
    for language, ending in ENDINGS.items():
        words = dict(WORDS[language])
        for source in sources.values():
            words |= source.names(language)
        for stem, source in sources.items():
            if language in source.languages:
                made[SHADERS / f"{stem}.{ending}"] = source.rendered(language, words, sources)
    return made


@dataclass(frozen=True)
class Source:
    """A lookup's one text. `stem`: the name of its file, and of those that are made of it."""

    stem: str
    text: str

    @property
    def languages(self) -> list[str]:
        """Those that have this lookup."""
        return self.text.partition("\n@for ")[2].partition("\n")[0].split()

    def names(self, language: str) -> dict[str, str]:
        """What a language, or a variant of WGSL, calls otherwise, by its name in the sources."""
        found = dict(re.findall(rf"^@name {language} (\w+) (.*)$", self.text, re.MULTILINE))
        if language == "wgsl":  # uniforms are members there: radtex_middle is radtex.middle
            for variable, struct in re.findall(r"var<uniform> (\w+): (\w+);", self.text):
                body = self.text.partition(f"struct {struct} {{\n")[2].partition("\n}")[0]
                members = re.findall(r"^    (\w+):", body, re.MULTILINE)
                found = {f"{variable}_{member}": f"{variable}.{member}" for member in members} | found
        return found

    def rendered(self, language: str, words: Mapping[str, str], sources: Mapping[str, Source]) -> str:
        """The lookup in a language; `words` are those that it spells otherwise."""
        writer = Wgsl(words) if language == "wgsl" else CLike(language, words)
        lines = []
        for line in written(list(self._statements(language)), writer):
            if line.startswith("@again "):
                _, stem, variant, macro = line.split()
                lines.append(sources[stem].again(variant, macro, words))
            else:
                lines.append(line)
        lines.insert(2, f"// Written by RadTex's .ci/build_shaders.py from shaders/source/{self.stem}.c.")
        return re.sub(r"\n{3,}", "\n\n", "\n".join([*lines, ""]))

    def again(self, variant: str, macro: str, words: Mapping[str, str]) -> str:
        """The functions that take an atlas, in WGSL as if `macro` were defined; names end in `variant`."""
        parts: list[list[tuple[str, bool]]] = [[]]
        for statement in self._statements("wgsl"):
            if statement[0] == "":
                parts.append([])
            else:
                parts[-1].append(statement)
        names = re.findall(r"(\w+)\(RADTEX_ATLAS", self.text)
        spelt = {**words, **{name: f"{name}_{variant}" for name in names}, **self.names(variant)}
        made = (
            "\n".join(written(part, Wgsl(spelt, MACROS | {macro: True})))
            for part in parts
            if any("(RADTEX_ATLAS" in text for text, _ in part)
        )
        return "\n\n".join(text for text in made if text)

    def _statements(self, language: str) -> Iterator[tuple[str, bool]]:
        """What a language has, statement by statement, and whether it is written in this language already."""
        begun: list[str] = []
        for line, own in self._lines(language):
            begun.append(line)
            code = line.partition("//")[0].rstrip()
            if own or not code or code.startswith(("#", "@")) or code.endswith((";", "{", "}")):
                yield "\n".join(begun), own or code.startswith("@")
                begun = []

    def _lines(self, language: str) -> Iterator[tuple[str, bool]]:
        mine, own, named = True, False, list[str]()
        for line in self.text.splitlines():
            word, *rest = line.split() or [""]
            if word == "@in":
                mine, own = language in rest, len(rest) == 1
                named += rest
            elif word == "@else":
                mine, own = language not in named, False
            elif word == "@end":
                mine, own, named = True, False, []
            elif mine and word not in ("@for", "@name"):
                yield line, own


def written(statements: Sequence[tuple[str, bool]], writer: CLike | Wgsl) -> Iterator[str]:
    """Statements in a language. Those that are in it already stay as they are."""
    for k, (text, own) in enumerate(statements):
        if text.endswith("{") and text[0].isalpha():  # a function
            rest = (line for line, _ in statements[k + 1 :])
            writer.body = "\n".join(takewhile(lambda line: line != "}", rest))
        lead = "//     " if text.startswith("//     ") and not own else ""  # code in a comment
        line = text if own else writer.written(text.removeprefix(lead))
        if line is not None and not writer.left_out:
            yield lead + line


@dataclass
class CLike:
    """GLSL, HLSL and Godot's language: what differs are words, and how uniforms are declared."""

    language: str
    words: Mapping[str, str]
    body: str = ""
    left_out: bool = False

    def written(self, text: str) -> str:
        """A statement in this language."""
        code, comment = _apart(text)
        if _FUNCTION.fullmatch(code):
            code = re.sub(r"\s*\n\s*", " ", code)
        hlsl = self.language == "hlsl"
        code = re.sub(r"^const ", "static const ", code) if hlsl else _HINT.sub("", code)
        if self.language == "godot":
            code = _TINY.sub("RADTEX_TINY", code)
        if code.startswith("uniform "):
            code = "\n".join(self._uniforms(code))
        return _wrapped(_spelt(code, self.words)) + comment

    def _uniforms(self, code: str) -> list[str]:
        """Uniforms: Godot declares each alone, and says how a texture is filtered."""
        plain = code.replace("mipmapped ", "")
        if self.language != "godot":
            return [plain]
        hint = (
            " : filter_linear_mipmap, repeat_disable" if plain != code else " : filter_linear, repeat_disable"
        )
        kind, names = plain.removeprefix("uniform ").removesuffix(";").split(" ", 1)
        return [f"uniform {kind} {name}{hint * (kind == 'sampler2D')};" for name in names.split(", ")]


@dataclass
class Wgsl:
    """WGSL: types behind names, let and var, select in place of `?`, if in place of #if."""

    words: Mapping[str, str]
    macros: Mapping[str, bool] = field(default_factory=lambda: MACROS)
    body: str = ""  # of the function that is being written
    struct: bool = False  # that is being written
    braces: int = 0  # open ones
    conditions: list[bool | None] = field(default_factory=list)  # open: known, or None if an override tells

    @property
    def left_out(self) -> bool:
        """Whether a condition that does not hold is open."""
        return False in self.conditions

    def written(self, text: str) -> str | None:
        """A statement in this language; None where it has none."""
        code, comment = _apart(text)
        if code.startswith("#"):
            line = self._condition(*code.partition(" ")[::2])
            return None if line is None else line + comment
        if self.left_out:
            return None
        deeper = " " * 4 * self.conditions.count(None)
        margin = " " * (len(code) - len(code.lstrip())) + deeper
        lines = [margin + line.replace("\n", "\n" + deeper) for line in self._statement(code.strip())]
        self.braces += code.count("{") - code.count("}")
        return _wrapped("\n".join(lines)) + comment

    def _condition(self, word: str, condition: str) -> str | None:
        """A condition of the preprocessor: an override answers it, or it is known, as around functions."""
        if word in ("#else", "#endif"):
            text, known = "} else {" if word == "#else" else "}", self.conditions.pop()
            then = [None if known is None else not known] if word == "#else" else []
        else:
            text, known = f"if {condition} {{", self.macros.get(condition, None if self.braces else True)
            then = [None if known is None else known == (word != "#ifndef")]
        level = self.braces + self.conditions.count(None)
        self.conditions += then
        return " " * 4 * level + text if known is None else None

    def _statement(self, code: str) -> list[str]:
        """A statement without its margin, line by line."""
        found: re.Match[str] | None
        if self.struct or code.startswith("struct "):
            self.struct = code != "};"
            found = _DECLARATION.fullmatch(code)
            lines = [f"{name}: {self._spelt(found[1])}," for name in found[2].split(", ")] if found else []
            return lines or [code.removesuffix(";")]
        if found := _DECLARATION.fullmatch(code):
            return [self._declared(found[1], part.strip()) for part in _split(found[2], ",")]
        if found := _FUNCTION.fullmatch(code):
            taken = ", ".join(self._parameter(part) for part in re.split(r",\s*", found[3]))
            return [f"fn {self._spelt(found[2])}({taken}) -> {self._spelt(found[1])} {{"]
        return [self._simple(code)]

    def _simple(self, code: str) -> str:
        """A statement that is one line here, too."""
        if found := _LOOP.fullmatch(_HINT.sub("", code)):
            return f"for (var {self._spelt(found[1])}; {self._spelt(found[2])}) {{"
        if code.startswith("if ("):
            end = _closing(code, len("if "))
            condition, then = self._spelt(code[len("if (") : end]), code[end + 1 :].strip()
            return f"if {condition} {{" + ("" if then == "{" else f" {self._simple(then)} }}")
        if found := _ASSIGNMENT.fullmatch(code):
            return f"{self._spelt(found[1])}{self._spelt(found[2])};"
        return self._spelt(code)

    def _parameter(self, code: str) -> str:
        kind, _, name = code.rpartition(" ")
        return f"{self._spelt(name)}: {self._spelt(kind)}" if kind else self._spelt(code)

    def _declared(self, kind: str, code: str) -> str:
        """A variable. One that the function sets again is a `var`."""
        found = _DECLARED.fullmatch(code)
        assert found is not None, code
        name, count, value = found.groups()
        spelt, kind, constant = self._spelt(name), self._spelt(kind.removeprefix("const ")), "const " in kind
        if constant:
            return f"const {spelt}: {kind} = {self._spelt(value)};"
        if value is None:
            return f"var {spelt}: {f'array<{kind}, {count}>' if count else kind};"
        sets = rf"(?<![\w.]){name}(?:(?:\.\w+|\[[^\]]*\])* [-+*/]?= |\+\+)"
        return f"{'var' if len(re.findall(sets, self.body)) > 1 else 'let'} {spelt} = {self._spelt(value)};"

    def _spelt(self, code: str) -> str:
        """An expression."""
        code = re.sub(r"\btextureLod\((\w+),", r"textureSampleLevel(\1, radtex_filtering,", _selected(code))
        return _spelt(re.sub(r"(<<|>>) ([a-z]\w*)\b(?!\()", r"\1 u32(\2)", code), self.words)


def _apart(text: str) -> tuple[str, str]:
    """A statement's code, and the comment behind it with the space before that."""
    found = re.fullmatch(r"(.*?)(\s*//[^\n]*)?", text, re.DOTALL)
    assert found is not None
    return found[1], found[2] or ""


def _spelt(code: str, words: Mapping[str, str]) -> str:
    return _NAME.sub(lambda found: words.get(found[0], found[0]), code)


def _selected(code: str) -> str:
    """`a ? b : c` as select(c, b, a), inside of brackets first."""
    made, k = "", 0
    while k < len(code):
        if code[k] not in "([":
            made += code[k]
        else:
            end = _closing(code, k)
            inner = ",".join(_selected(part) for part in _split(code[k + 1 : end], ","))
            alone = code[k] == "(" and inner.startswith("select(") and not re.search(r"\w$", made)
            bare = alone and _closing(inner, len("select")) == len(inner) - 1
            made += inner if bare else code[k] + inner + code[end]
            k = end
        k += 1
    condition, *rest = _split(made, " ? ")
    if not rest:
        return made
    then, otherwise = _split(rest[0], " : ")
    margin = condition[: len(condition) - len(condition.lstrip())]
    return f"{margin}select({otherwise}, {then}, {condition.strip()})"


def _split(code: str, separator: str) -> list[str]:
    """The parts of an expression between separators outside of brackets."""
    parts, k, begin = [], 0, 0
    while k < len(code):
        if code[k] in "([":
            k = _closing(code, k)
        elif code.startswith(separator, k):
            parts.append(code[begin:k])
            begin = k + len(separator)
        k += 1
    return [*parts, code[begin:]]


def _closing(code: str, begin: int) -> int:
    """Where the bracket closes that opens at `begin`. Raises ValueError if it does not."""
    depth = 0
    for k in range(begin, len(code)):
        depth += (code[k] in "([") - (code[k] in ")]")
        if depth == 0:
            return k
    raise ValueError(f"a bracket is not closed: {code}")


def _wrapped(code: str) -> str:
    """Lines of at most WIDTH: broken behind a comma or before an operator, in as few brackets as can be."""
    return "\n".join(_broken(line) for line in code.split("\n"))


def _broken(line: str) -> str:
    if len(line) <= WIDTH or line.startswith("#"):
        return line
    is_function = line[0].isalpha()
    indent = line.index("(") + 1 if is_function else len(line) - len(line.lstrip()) + 4
    places = [found.start() for found in re.finditer(r"(?<=,) | (?=[-+*/|] )", line[:WIDTH])]
    depths = {k: len(re.findall(r"[(\[]", line[:k])) - len(re.findall(r"[)\]]", line[:k])) for k in places}
    best = max((k for k in places if k > indent), key=lambda k: (-depths[k], k))
    return line[:best] + "\n" + _broken(" " * indent + line[best + 1 :])


if __name__ == "__main__":
    main()
