# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show in Browser: the server over real sockets, and the operator, with a program as the browser."""

from __future__ import annotations

import http.client
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import webbrowser
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit
from urllib.request import urlopen

import bpy
import pytest

from radtex_addon.export.page_process import PageProcess
from radtex_addon.export.page_server import HERE
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui import registration
from radtex_addon.ui.jobs import browser, jobs
from radtex_addon.ui.operators.browser_operator import open_exported
from radtex_addon.ui.operators.export_sources import Place, submit
from radtex_addon.ui.panel import jobs_panel
from radtex_addon.worker.job import Job
from tests.blender.recorded_layout import RecordedLayout
from tests.blender.test_swap import NAME, PLAIN, bake_of, ball
from tests.blender.ui_stage import finish_jobs

pytestmark = pytest.mark.one_blender

radtex: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's

PARENT = Path(__file__).with_name("page_parent.py")
TYPES = {
    "index.html": "text/html; charset=utf-8",
    "viewer.js": "text/javascript; charset=utf-8",
    "viewer.css": "text/css; charset=utf-8",
    "a.wasm": "application/wasm",
    "a.ktx2": "image/ktx2",
    "a.glb": "model/gltf-binary",
    "a.export.json": "application/json",
    "a.flat.png": "image/png",
}


# the server


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder to be served, with a secret beside it."""
    made = tmp_path / "My vase.web"
    (made / "shaders").mkdir(parents=True)
    for name in TYPES:
        (made / name).write_text(name, encoding="utf-8")
    (tmp_path / "secret.txt").write_text("secret")
    (tmp_path / "My vase.web2").mkdir()
    (tmp_path / "My vase.web2/secret.txt").write_text("secret")
    return made


@pytest.fixture
def process() -> Iterator[PageProcess]:
    made = PageProcess()
    yield made
    made.close()


def ask(address: str, path: str = "", **headers: str) -> tuple[int, http.client.HTTPMessage, bytes]:
    """Status, headers and content that a raw path, not tidied up as by browsers, is answered with."""
    parts = urlsplit(address)
    assert parts.hostname == HERE
    connection = http.client.HTTPConnection(HERE, parts.port, timeout=10)
    try:
        connection.request("GET", path or parts.path, headers=headers)
        answer = connection.getresponse()
        return answer.status, answer.headers, answer.read()
    finally:
        connection.close()


def is_served(address: str) -> bool:
    try:
        return ask(address)[0] == 200
    except (OSError, http.client.HTTPException):  # ended before, or in the middle of its answer
        return False


def wait_until_gone(address: str) -> None:
    end = time.monotonic() + 10
    while is_served(address):
        assert time.monotonic() < end, "the server goes on"
        time.sleep(0.05)


def test_files_are_served_with_their_types_and_kept_by_no_browser(folder: Path, process: PageProcess) -> None:
    address = process.address_of(folder)
    assert address.endswith("/My%20vase.web/")
    for name, kind in TYPES.items():
        status, headers, content = ask(address, f"{urlsplit(address).path}{name}")
        assert (status, headers["Content-Type"], content) == (200, kind, name.encode())
        assert headers["Cache-Control"] == "no-store"
    _, headers, _ = ask(address)
    (folder / "index.html").write_text("exported anew")  # within the second that HTTP's dates tell apart
    assert ask(address)[2] == b"exported anew"
    status, headers, _ = ask(address, address.removesuffix("/").partition(str(urlsplit(address).port))[2])
    assert (status, headers["Location"]) == (301, "/My%20vase.web/")


OUTSIDE = (
    "/My%20vase.web/../secret.txt",
    "/My%20vase.web/%2e%2e/secret.txt",
    "/My%20vase.web/..%2fsecret.txt",
    "/My%20vase.web/..%5csecret.txt",
    "/My%20vase.web/shaders/../../secret.txt",
    "/My%20vase.web//{parent}/secret.txt",
    "/My%20vase.web/%00",
    "/../secret.txt",
    "/secret.txt",
    "/%2e%2e/",
    "/My%20vase.web2/secret.txt",
    "/My%20vase.web/link.txt",
    "/My%20vase.web/linked/secret.txt",
    "/My%20vase.web/linked/",
    "/My%20vase.web/pipe",
    "/",
    "/.",
)


def test_nothing_outside_of_the_folder_is_served(folder: Path, process: PageProcess) -> None:
    (folder / "link.txt").symlink_to(folder.parent / "secret.txt")
    (folder / "linked").symlink_to(folder.parent)
    if sys.platform != "win32":
        os.mkfifo(folder / "pipe")
    address = process.address_of(folder)
    for path in OUTSIDE:
        status, _, content = ask(address, path.replace("{parent}", str(folder.parent)))
        assert status == 404, path
        assert b"secret" not in content.replace(path.encode(), b""), path


def test_a_page_of_another_host_is_refused(folder: Path, process: PageProcess) -> None:
    """Such as one from the internet whose name was made to lead to this machine."""
    address = process.address_of(folder)
    port = urlsplit(address).port
    assert ask(address, Host=f"evil.example:{port}")[0] == 403
    assert ask(address, Host="")[0] == 403
    assert ask(address, Host=f"localhost:{port}")[0] == 200


def test_connections_that_ask_for_nothing_keep_nobody_waiting(folder: Path, process: PageProcess) -> None:
    """Nor do those that begin a request and leave it."""
    address = process.address_of(folder)
    begin, idle = time.monotonic(), []
    try:
        for number in range(300):
            idle.append(socket.create_connection((HERE, urlsplit(address).port), timeout=10))
            if number % 2:
                idle[-1].sendall(b"GET / HTTP/1.1\r\n")
        for _ in range(3):
            assert ask(address)[0] == 200
        assert process.address_of(folder) == address
        assert time.monotonic() - begin < 10  # half a minute, where each second some were let in
    finally:
        for one in idle:
            one.close()


def test_folders_of_one_name_have_addresses_of_their_own(
    folder: Path, process: PageProcess, tmp_path: Path
) -> None:
    other = tmp_path / "elsewhere" / folder.name
    other.mkdir(parents=True)
    (other / "index.html").write_text("the other")
    first, second = process.address_of(folder), process.address_of(other)
    assert process.address_of(folder) == first
    assert urlsplit(first).port == urlsplit(second).port
    assert (ask(first)[2], ask(second)[2]) == (b"index.html", b"the other")


def test_the_server_ends_when_it_is_closed_and_when_its_parent_is_killed(folder: Path) -> None:
    process = PageProcess()
    address = process.address_of(folder)
    assert is_served(address)
    process.close()
    wait_until_gone(address)
    with subprocess.Popen([sys.executable, str(PARENT), str(folder)], stdout=subprocess.PIPE) as parent:
        assert parent.stdout is not None
        address = next(line for line in parent.stdout if line.startswith(b"http")).decode().strip()
        assert is_served(address)
        parent.kill()
    wait_until_gone(address)


def test_a_server_that_was_killed_is_started_again(folder: Path) -> None:
    first = browser.address_of(folder)
    assert browser._session.server is not None
    browser._session.server._process.kill()
    browser._session.server._process.wait()
    second = browser.address_of(folder)
    assert is_served(second)
    assert not is_served(first)
    browser.end_server()
    wait_until_gone(second)


# the operator


@pytest.fixture(scope="module")
def baked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a bake; not to be written to."""
    return bake_of(PLAIN, tmp_path_factory.mktemp("baked")).parent


@pytest.fixture
def bake(baked: Path, tmp_path: Path) -> Iterator[Path]:
    """A bake of the one object in the open file, with RadTex enabled."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    ball()
    registration.register()
    yield Path(shutil.copytree(baked, tmp_path / "bake"))
    registration.unregister()


@contextmanager
def default_browser(monkeypatch: pytest.MonkeyPatch, folder: Path) -> Iterator[list[str]]:
    """A program as the default browser that writes addresses down; they are in the list afterwards."""
    notes, program, found = folder / "opened.txt", folder / "a browser", list[str]()
    program.write_text(f'#!/bin/sh\necho "$1" >> {notes}\n')
    program.chmod(0o755)
    monkeypatch.setattr(webbrowser, "_tryorder", ["noting"])
    monkeypatch.setattr(
        webbrowser, "_browsers", {"noting": [None, webbrowser.GenericBrowser([str(program), "%s"])]}
    )
    yield found
    found += notes.read_text().split() if notes.is_file() else []


def test_one_click_exports_for_the_web_if_needed_and_opens_the_page(
    bake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bpy.data.objects[NAME].select_set(False)
    out = bake / f"{NAME}.web"
    manifest = out / f"{NAME}.export.json"
    with default_browser(monkeypatch, tmp_path) as opened:
        radtex.show_in_browser(object=NAME, bake=str(bake))
        first = manifest.stat().st_mtime_ns
        radtex.show_in_browser(object=NAME, bake=str(bake))
        assert manifest.stat().st_mtime_ns == first, "it was exported already"
        later = time.time() + 5
        os.utime(bake / f"{NAME}.radiance.json", (later, later))  # as after a bake
        radtex.export(bake=str(bake), target="web", mirror=True, overwrite=True)
        os.utime(manifest, (later - 9, later - 9))
        radtex.show_in_browser(object=NAME, bake=str(bake))
        assert manifest.stat().st_mtime_ns > (later - 9) * 1e9, "the bake is newer"
        assert "mirror" in json.loads(manifest.read_text()), "and exported as before"
        radtex.show_in_browser(directory=str(out))
    assert len(opened) == 4
    assert len(set(opened)) == 1
    with urlopen(opened[0]) as answer:
        assert b"<title>RadTex</title>" in answer.read()
    with urlopen(f"{opened[0]}{manifest.name}") as answer:
        assert json.loads(answer.read())["name"] == NAME
    registration.unregister()
    wait_until_gone(opened[0])
    registration.register()


def test_a_worker_exports_and_its_page_opens_when_it_is_done(
    bake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = bake / f"{NAME}.web"
    place = Place(NAME, bake / f"{NAME}.radiance.json", out)
    with default_browser(monkeypatch, tmp_path) as opened:
        submit([place], ExportSpec(Target.WEB), overwrite=True, completion=jobs.Completion(open_exported))
        with pytest.raises(RuntimeError, match=r"Ball\.web is being exported: wait"):
            radtex.show_in_browser(object=NAME, bake=str(bake))
        (job,) = finish_jobs()
        assert job.state == "done", job.message
    (address,) = opened
    assert is_served(address)
    assert address.removeprefix("http://") in texts_of(job), "the panel has nowhere else to tell it"
    browser.end_server()
    assert "Show in Browser" in texts_of(job)
    radtex.clear_jobs()


def texts_of(job: Job) -> list[str]:
    """What the job's box in the panel says."""
    layout = RecordedLayout()
    jobs_panel._draw_job(layout, job)
    return layout.texts


def test_what_cannot_be_shown_is_said(bake: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with default_browser(monkeypatch, tmp_path) as opened:
        with pytest.raises(RuntimeError, match="holds no web page: export the bake for Web first"):
            radtex.show_in_browser(directory=str(bake))
        (bake / f"{NAME}.web").mkdir()
        (bake / f"{NAME}.web/mine.txt").touch()
        with pytest.raises(RuntimeError, match="holds other things than an export"):
            radtex.show_in_browser(object=NAME, bake=str(bake))
        (bake / f"{NAME}.preview.blend").unlink()
        shutil.rmtree(bake / f"{NAME}.web")
        with pytest.raises(RuntimeError, match="bake it again"):
            radtex.show_in_browser(object=NAME, bake=str(bake))
    assert opened == []
