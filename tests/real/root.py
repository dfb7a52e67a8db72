# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small Debians of their own, with the programs that tests run.

`PROGRAMS` has Godot, Chromium, Mesa, shader compilers and wgpu, `BLENDER` has Blender's window, `COMPILERS`
what game engines compile with: Mono's compiler for C# and Microsoft's for HLSL. Each is made once, in the
user's cache, by debootstrap; `python tests/real/root.py` makes them without a test, `BLENDER` where
RADTEX_WINDOW is set.
What runs in it is in a namespace of its own: it sees the root read-only, this repository read-only at
/repository, what both sides share at /shared, an empty /tmp, and the machine's network. Nothing stays mounted
or running afterwards.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

if sys.platform != "win32":
    import fcntl

REPOSITORY = Path(__file__).resolve().parents[2]
CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "radtex"
SUITE = "sid"  # the one with a Godot of 4.6
_KEYRING = Path("/usr/share/keyrings/debian-archive-keyring.gpg")
_CERTIFICATES = Path("/etc/ssl/certs/ca-certificates.crt")
_PIP_SETTINGS = ("/etc/pip.conf", "~/.pip/pip.conf", "~/.config/pip/pip.conf")
_QUICK_DPKG = "force-unsafe-io\npath-exclude=/usr/share/doc/*\npath-exclude=/usr/share/locale/*\n"
_PATIENCE = 1200  # seconds that a step of building may take: it fetches from the network
# Runs a script of the shared folder for each line, which names it, and says its exit code.
_SHELL = """while read -r script; do
sh "/shared/$script" </dev/null >"/shared/$script.out" 2>"/shared/$script.err"
echo $?
echo ANSWERED
done"""
_SCRIPT = ".script"
# What is mounted or started in it ends with it, and it ends with who started it.
_NAMESPACE = ("setpriv", "--pdeathsig", "KILL", "unshare", "--mount", "--pid", "--fork", "--kill-child")
_ENTER = REPOSITORY / "tests/real/enter.sh"
_ENVIRONMENT = {
    "PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin:/usr/games",
    "HOME": "/root",
    "LANG": "C.UTF-8",
}
ANSWERED = "ANSWERED"  # the line that ends an answer of a Server
_MESA = {
    # Where Mesa and Godot find the shaders again that they compiled when they were started before.
    "XDG_CACHE_HOME": "/shared/.kept/cache",
    "XDG_DATA_HOME": "/shared/.kept/data",
    # To optimise our shaders takes Mesa longer than to draw a small picture by them.
    "GALLIVM_PERF": "nopt",
}


@dataclass(frozen=True)
class Recipe:
    """What a root is made of: Debian's packages, modules by pip, and what a shell does after that."""

    packages: tuple[str, ...]
    modules: tuple[str, ...]
    steps: tuple[str, ...] = ()
    suite: str = SUITE

    @property
    def scripts(self) -> tuple[str, ...]:
        """What is executed in a bare Debian, in this order."""
        install = f"""
set -e
export DEBIAN_FRONTEND=noninteractive
apt-get -q -o Acquire::Check-Valid-Until=false update
apt-get -q install --yes --no-install-recommends {" ".join(self.packages)}
apt-get clean
"""
        pip = f"pip install --break-system-packages --no-cache-dir {' '.join(self.modules)}"
        return install, *([pip] if self.modules else []), *self.steps

    @property
    def path(self) -> Path:
        """Where its root lies, built or not."""
        recipe = repr((self.suite, _QUICK_DPKG, *self.scripts))
        return CACHE / f"real-{hashlib.sha256(recipe.encode()).hexdigest()[:12]}"


PROGRAMS = Recipe(
    packages=(
        *("godot", "chromium", "fonts-dejavu-core"),
        *("libgl1-mesa-dri", "libegl1", "libegl-mesa0", "libgles2", "mesa-vulkan-drivers"),
        *("xvfb", "xauth", "xdotool", "imagemagick"),
        *("glslang-tools", "spirv-tools", "spirv-cross", "vkd3d-compiler"),
        *("python3-numpy", "python3-cffi", "python3-pip"),
    ),
    modules=("wgpu==0.32.0",),
)
_SHIPPED = ("openexr==3.5.3", "uvunwrap==0.3.0", "xatlas==0.0.11", "flip-evaluator==1.7")
# Its Python is a newer one than the wheels that RadTex ships are for: /wheels has ours.
BLENDER = Recipe(
    packages=(
        *("blender", "blender-data", "libgl1-mesa-dri", "libegl1", "libegl-mesa0", "libgl1"),
        *("xvfb", "xauth", "xdotool", "imagemagick"),
        *("python3-numpy", "python3-requests", "python3-zstandard", "python3-pip"),
        *("build-essential", "cmake", "ninja-build", "python3-dev"),
    ),
    modules=("cattrs",),
    steps=(f"pip wheel --no-cache-dir --no-deps --wheel-dir /wheels {' '.join(_SHIPPED)}",),
)
# No program runs of compushady: its source archive has Microsoft's compiler as a library, dxc for Linux.
DXC = "/usr/local/lib/libdxcompiler.so"
_UNPACK_DXC = f"""
set -e
cd /tmp
pip download --no-deps --no-build-isolation --no-binary :all: compushady==0.17.5
tar -xzOf compushady-0.17.5.tar.gz --wildcards '*/libdxcompiler_x86_64.so.*' > {DXC}
rm compushady-0.17.5.tar.gz
"""
COMPILERS = Recipe(
    packages=("mono-mcs", "python3-pip", "python3-setuptools", "python3-wheel"),
    modules=(),
    steps=(_UNPACK_DXC,),
    suite="bookworm",  # the newest one with Mono's C# compiler
)


class RootUnavailableError(Exception):
    """One line that says why this machine cannot have the root."""


class ServerEndedError(Exception):
    """A program that answers lines has ended; what it said."""


class Started(subprocess.Popen[bytes]):
    """A program in the root. Whatever it started itself ends with it."""

    def terminate(self) -> None:
        self.kill()  # `unshare` ignores SIGTERM; at its death the kernel kills all that it held

    def __exit__(self, *error: Any) -> None:
        self.kill()
        super().__exit__(*error)


class Server:
    """A program in the root that answers lines: it reads one, says what it has to say, then `ANSWERED`.

    Started once, it saves each of many questions its start. It ends where its input does.
    """

    def __init__(self, command: Sequence[str]) -> None:
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def ask(self, line: str, timeout: float) -> str:
        """What it says to a line. Raises ServerEndedError, with what it said, where it ended."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        said: list[str] = []
        patience = threading.Timer(timeout, self._process.kill)
        patience.start()
        try:
            with suppress(BrokenPipeError):
                self._process.stdin.write(f"{line}\n")
                self._process.stdin.flush()
            for answer in self._process.stdout:
                if answer == f"{ANSWERED}\n":
                    return "".join(said)
                said.append(answer)
        finally:
            patience.cancel()
        raise ServerEndedError("".join(said))

    def end(self) -> None:
        """Let it end by itself, so that what it cost is known, or end it."""
        assert self._process.stdin is not None
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        assert self._process.stdout is not None
        self._process.stdout.close()


@dataclass(frozen=True)
class Root:
    """The root at `path`; `exchange` is the folder seen inside as /shared."""

    path: Path
    exchange: Path

    def command(
        self, argv: Sequence[str], *, env: Mapping[str, str] | None = None, cwd: str = "/shared"
    ) -> list[str]:
        """What to execute on this machine to execute `argv` inside; `env` adds to what is set."""
        variables = [f"{name}={value}" for name, value in {**_ENVIRONMENT, **_MESA, **(env or {})}.items()]
        places = (str(self.path), str(self.exchange), str(REPOSITORY), cwd)
        return [*_entered(*places), "/usr/bin/env", "-i", *variables, *argv]

    def run(
        self,
        argv: Sequence[str],
        *,
        env: Mapping[str, str] | None = None,
        timeout: float = 240,
        cwd: str = "/shared",
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end in the folder `cwd` of the inside; its exit code is unchecked.

        A shell that stays inside starts it, for to enter takes longer than many a program does.
        Raises ServerEndedError where it takes too long.
        """
        variables = [f"{name}={value}" for name, value in (env or {}).items()]
        script = f"cd {shlex.quote(cwd)} && exec {shlex.join(['env', *variables, *argv])}\n"
        (self.exchange / _SCRIPT).write_text(script, encoding="utf-8")
        code = int(self.ask(["sh", "-c", _SHELL], _SCRIPT, timeout))
        said = [(self.exchange / f"{_SCRIPT}.{end}").read_text(encoding="utf-8") for end in ("out", "err")]
        return subprocess.CompletedProcess(list(argv), code, *said)

    def start(
        self,
        argv: Sequence[str],
        *,
        env: Mapping[str, str] | None = None,
        cwd: str = "/shared",
        log: Path | None = None,
    ) -> Started:
        """Start a program that speaks into the file `log`; `with` ends it, as do kill and terminate."""
        command = self.command(argv, env=env, cwd=cwd)
        with (log or Path(os.devnull)).open("wb") as output:
            return Started(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)

    def server(self, argv: Sequence[str]) -> Server:
        """The program that answers lines, started when it is first asked for, and again after it ended."""
        known = (self, tuple(argv))
        if known not in _SERVERS:
            _SERVERS[known] = Server(self.command(argv))
        return _SERVERS[known]

    def ask(self, argv: Sequence[str], line: str, timeout: float = 240) -> str:
        """What that program says to a line. Raises ServerEndedError where it ended."""
        try:
            return self.server(argv).ask(line, timeout)
        except ServerEndedError:
            self.end_server(argv)
            raise

    def end_server(self, argv: Sequence[str]) -> None:
        """End a program that answers lines."""
        _SERVERS.pop((self, tuple(argv))).end()

    def end_servers(self) -> None:
        """End all programs that answer lines."""
        for known in [known for known in _SERVERS if known[0] == self]:
            _SERVERS.pop(known).end()

    def shared(self, name: str) -> tuple[Path, str]:
        """A new folder that both sides see: its path here and its path inside."""
        folder = Path(tempfile.mkdtemp(prefix=f"{name}-", dir=self.exchange))
        return folder, f"/shared/{folder.name}"


_SERVERS: dict[tuple[Root, tuple[str, ...]], Server] = {}


def screen(argv: Sequence[str], width: int = 1280, height: int = 720) -> list[str]:
    """`argv` before an X screen of its own, for programs that want a window."""
    return ["xvfb-run", "--auto-servernum", f"--server-args=-screen 0 {width}x{height}x24", *argv]


def ready_root(recipe: Recipe) -> tuple[Path, float]:
    """The root, built if it is not there, and how many seconds that took.

    Raises RootUnavailableError where it cannot be built, CalledProcessError or TimeoutExpired where
    building it failed.
    """
    if sys.platform != "linux" or os.geteuid() != 0:
        raise RootUnavailableError("a root of real programs needs Linux and the rights of its user root")
    start, path = time.monotonic(), recipe.path
    CACHE.mkdir(parents=True, exist_ok=True)
    with _locked(recipe.path.with_suffix(".lock")):
        if not path.is_dir():
            _build(recipe)
            return path, time.monotonic() - start
    return path, 0.0


def _build(recipe: Recipe) -> None:
    missing = [
        name for name in ("setpriv", "unshare", "chroot", "apt-get", "dpkg-deb") if shutil.which(name) is None
    ]
    if missing or not _KEYRING.is_file():
        raise RootUnavailableError(f"a root of real programs needs {' and '.join(missing) or _KEYRING}")
    mirror, unfinished = _mirror(), recipe.path.with_name(f"{recipe.path.name}.unfinished")
    shutil.rmtree(unfinished, ignore_errors=True)
    with tempfile.TemporaryDirectory(dir=CACHE) as folder:
        command, variables = _debootstrap(Path(folder))
        options = [f"--keyring={_KEYRING}", "--variant=minbase"]
        _checked(
            [*_NAMESPACE, *command, *options, recipe.suite, str(unfinished), mirror], os.environ | variables
        )
    (unfinished / "etc/dpkg/dpkg.cfg.d/radtex").write_text(_QUICK_DPKG)
    (unfinished / "etc/hosts").write_text("127.0.0.1 localhost\n::1 localhost\n")
    shutil.copyfile("/etc/resolv.conf", unfinished / "etc/resolv.conf")
    for name in ("shared", "repository"):
        (unfinished / name).mkdir()
    enter = _entered(str(unfinished), "", "", "/")
    debian, *others = recipe.scripts
    _checked([*enter, "/bin/sh", "-c", debian], os.environ | _ENVIRONMENT)
    with _pip_configured(unfinished) as variables:
        for script in others:
            _checked([*enter, "/bin/sh", "-c", script], os.environ | _ENVIRONMENT | variables)
    unfinished.rename(recipe.path)


def _entered(root: str, shared: str, repository: str, folder: str) -> list[str]:
    """How to run a command in a root; without `shared`, as its administrator, who writes to it."""
    return [*_NAMESPACE, "/bin/sh", str(_ENTER), root, shared, repository, folder]


def _mirror() -> str:
    """The mirror of Debian that this machine's apt uses, or Debian's own."""
    listed = subprocess.run(
        ["apt-get", "indextargets", "--format", "$(ORIGIN) $(REPO_URI)"],
        capture_output=True,
        text=True,
        check=False,
    )
    origins = [line.split(" ") for line in listed.stdout.splitlines()]
    archives = [uri for origin, uri in origins if origin == "Debian" and uri.rstrip("/").endswith("/debian")]
    mirror = min(archives, default="http://deb.debian.org/debian")
    try:
        with urllib.request.urlopen(f"{mirror.rstrip('/')}/dists/{SUITE}/InRelease", timeout=30):
            return mirror
    except (urllib.error.URLError, TimeoutError) as error:
        raise RootUnavailableError(f"a root of real programs needs {mirror}: {error}") from error


def _debootstrap(folder: Path) -> tuple[list[str], dict[str, str]]:
    """The program and variables that it needs; unpacked in `folder` where it is not installed."""
    if shutil.which("debootstrap"):
        return ["debootstrap"], {}
    _checked(["apt-get", "download", "debootstrap"], os.environ, folder)
    (package,) = folder.glob("debootstrap_*.deb")
    _checked(["dpkg-deb", "-x", str(package), str(folder)], os.environ)
    return [str(folder / "usr/sbin/debootstrap")], {"DEBOOTSTRAP_DIR": str(folder / "usr/share/debootstrap")}


@contextmanager
def _pip_configured(root: Path) -> Iterator[dict[str, str]]:
    """Lend pip inside this machine's settings, which may hold a password; the variables that it needs."""
    lent = [(Path(name).expanduser(), root / name.replace("~", "root").lstrip("/")) for name in _PIP_SETTINGS]
    lent = [(source, target) for source, target in lent if source.is_file()]
    for source, target in lent:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
    variables = {}
    if _CERTIFICATES.is_file():
        variables = {"PIP_CERT": str(_CERTIFICATES)}
        certificates = root / _CERTIFICATES.relative_to("/")
        certificates.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(_CERTIFICATES, certificates)
    yield variables
    for _, target in lent:
        target.unlink()


def _checked(command: Sequence[str], variables: Mapping[str, str], folder: Path | None = None) -> None:
    """Run a step of the build; CalledProcessError, with the end of what it said, where it fails."""
    done = subprocess.run(
        command,
        env=variables,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=_PATIENCE,
        check=False,
    )
    if done.returncode != 0:
        sys.stderr.write(done.stdout.decode(errors="replace")[-4000:])
        raise subprocess.CalledProcessError(done.returncode, shlex.join(command[-3:]), done.stdout)


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """One process at a time; the others wait."""
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


if __name__ == "__main__":
    try:
        for wanted in (PROGRAMS, COMPILERS, *[BLENDER] * bool(os.environ.get("RADTEX_WINDOW"))):
            found, seconds = ready_root(wanted)
            print(f"{found}: built in {seconds:.0f} s" if seconds else f"{found}: was there")
    except RootUnavailableError as error:
        sys.exit(str(error))
