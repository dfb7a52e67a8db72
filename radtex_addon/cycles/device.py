# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose the device that renders: the CPU, or a GPU that Cycles supports."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from importlib import import_module
from typing import Any, cast

import bpy

from ..core.errors import InputError
from ..core.messages import Message, Setting, do

GPU_TYPES = ("OPTIX", "CUDA", "HIP", "METAL", "ONEAPI")  # in the order in which `gpu` tries them


@contextmanager
def use_device(scene: bpy.types.Scene, wish: str) -> Iterator[str]:
    """Let `scene` render on the device `wish`, and restore Blender's preferences afterwards.

    `wish` is `auto` (the GPU that is switched on in Blender's preferences, else the CPU), `cpu`, `gpu` (any
    GPU), or one of Cycles's types, such as `optix`. Yields the type that renders, such as "CPU" or "OPTIX".
    Raises InputError if there is no such device.
    """
    with _switched_on(wish) as chosen:
        cast(Any, scene).cycles.device = "CPU" if chosen == "CPU" else "GPU"
        yield chosen


@contextmanager
def _switched_on(wish: str) -> Iterator[str]:
    """Within the context, the device `wish` is switched on in Blender's preferences; yields its type."""
    preferences = _cycles_preferences()
    before = preferences.compute_device_type
    switches = {device.id: device.use for device in preferences.devices}
    try:
        yield _choose(preferences, wish.upper())
    finally:
        if preferences.compute_device_type != before:
            preferences.compute_device_type = before
        for index, device in reversed(list(enumerate(preferences.devices))):
            if device.id not in switches:  # listed only because we asked for its type
                preferences.devices.remove(index)
            elif device.use != switches[device.id]:
                device.use = switches[device.id]


def check_device(wish: str) -> None:
    """Raises InputError if this machine has no such device: see `use_device`. Changes nothing."""
    if (problem := _why_not(wish)) is not None:
        raise InputError.of(problem)


@lru_cache(maxsize=8)
def _why_not(wish: str) -> Message | None:
    """Why the device cannot be used, None if it can. Drivers are asked once, as that may take a second."""
    if wish in ("auto", "cpu"):
        return None
    try:
        with _switched_on(wish):
            return None
    except InputError as error:
        return error.message


def preferred_device() -> str:
    """The device that `auto` means here, for another Blender process that does not have these preferences."""
    return _choose(_cycles_preferences(), "AUTO").lower()


def known_devices() -> list[tuple[str, str]]:
    """Type and name of each device that Cycles finds here, whether it is switched on or not.

    Changes nothing. Raises InputError where Cycles's add-on is switched off.
    """
    known = {item[0] for item in _cycles_preferences().get_device_types(bpy.context)}
    cycles: Any = import_module("_cycles")  # Blender's own, which is not there where Cycles is not built in
    kinds = ("CPU", *(kind for kind in GPU_TYPES if kind in known))
    found = [(kind, str(name)) for wish in kinds for name, kind, *_ in cycles.available_devices(wish)]
    return list(dict.fromkeys(found))


def _cycles_preferences() -> Any:
    """The preferences of Cycles's add-on. Raises InputError where it is switched off."""
    addon = bpy.context.preferences.addons.get("cycles")
    if addon is None:
        raise InputError("Cycles is switched off: enable its add-on in Blender's preferences")
    return addon.preferences


def _choose(preferences: Any, wish: str) -> str:
    if wish == "CPU":
        return "CPU"
    if wish == "AUTO":
        kind = preferences.compute_device_type
        enabled = kind != "NONE" and any(d.use and d.type == kind for d in preferences.devices)
        return str(kind) if enabled else "CPU"
    known = {item[0] for item in preferences.get_device_types(bpy.context)}
    wanted = GPU_TYPES if wish == "GPU" else (wish,)
    for kind in (kind for kind in wanted if kind in known):
        devices = [d for d in preferences.get_devices_for_type(kind) if d.type == kind]
        if devices:
            preferences.compute_device_type = kind
            for device in devices:
                device.use = True
            return kind
    raise InputError(
        f"this machine has no device '{wish.lower()}' for Cycles", do("choose auto, or cpu", Setting.DEVICE)
    )
