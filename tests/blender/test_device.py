# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The device that was wished for renders, and the preferences are given back as they were."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.cycles import device as module
from radtex_addon.cycles.device import use_device

context: Any = bpy.context  # to the stubs, every pointer may be None


def real() -> Any:
    return context.preferences.addons["cycles"].preferences


def state(preferences: Any) -> tuple[str, list[tuple[str, str, bool]]]:
    return preferences.compute_device_type, [(d.id, d.type, d.use) for d in preferences.devices]


@dataclass
class Device:
    id: str
    type: str
    use: bool = False


class Listed(list[Device]):
    def remove(self, index: Any) -> None:  # a collection property's takes the place
        del self[index]


@dataclass
class Preferences:
    """Cycles's preferences on a machine that has `present`; `devices` is what Blender has listed so far."""

    present: list[Device]
    compute_device_type: str = "NONE"
    devices: Any = field(default_factory=Listed)

    def get_device_types(self, _context: object) -> list[tuple[str, str, str, int]]:
        kinds = ("NONE", "CUDA", "OPTIX", "HIP", "ONEAPI")
        return [(kind, kind, "", number) for number, kind in enumerate(kinds)]

    def get_devices_for_type(self, kind: str) -> list[Device]:
        """As Blender's: it lists what it finds, GPUs switched on, and shows the CPU beside them."""
        found = [device for device in self.present if device.type in {kind, "CPU"}]
        for device in found:
            if device.id not in {listed.id for listed in self.devices}:
                device.use = device.type != "CPU"
                self.devices.append(device)
        return found


@pytest.fixture
def workstation(monkeypatch: pytest.MonkeyPatch) -> Preferences:
    """Two GPUs by OptiX and CUDA; the preferences have the second one on, by OptiX."""
    kinds = ("OPTIX", "CUDA")
    present = [Device(f"{kind}_{number}", kind) for kind in kinds for number in (0, 1)]
    preferences = Preferences([*present, Device("CPU", "CPU")])
    preferences.get_devices_for_type("OPTIX")
    preferences.compute_device_type = "OPTIX"
    for device in preferences.devices:
        device.use = device.id == "OPTIX_1"
    monkeypatch.setattr(module, "_cycles_preferences", lambda: preferences)
    return preferences


def test_auto_is_the_cpu_where_no_gpu_is_switched_on() -> None:
    before = state(real())
    with use_device(context.scene, "auto") as name:
        assert name == "CPU"
        assert context.scene.cycles.device == "CPU"
        real().get_devices_for_type("CPU")
        assert state(real()) != before, "what Blender lists meanwhile"
    assert state(real()) == before
    for wish in ("hip", "oneapi", "toaster"):
        with suppress(InputError), use_device(context.scene, wish):  # a machine may have one
            pass
        assert state(real()) == before


def test_auto_takes_the_gpus_that_the_preferences_have_on(workstation: Preferences) -> None:
    before = state(workstation)
    with use_device(context.scene, "auto") as name:
        assert name == "OPTIX"
        assert context.scene.cycles.device == "GPU"
        assert state(workstation) == before, "just those, and no more"
    assert state(workstation) == before
    with use_device(context.scene, "CPU") as name:
        assert name == "CPU"
        assert context.scene.cycles.device == "CPU"
    for device in workstation.devices:
        device.use = device.type == "CPU"
    with use_device(context.scene, "auto") as name:
        assert name == "CPU", "every GPU is switched off"
    workstation.present = [Device("HIP_0", "HIP")]
    with use_device(context.scene, "gpu") as name:
        assert name == "HIP", "what there is"


@pytest.mark.parametrize(("wish", "kind"), [("gpu", "OPTIX"), ("cuda", "CUDA"), ("OptiX", "OPTIX")])
def test_a_wish_switches_all_gpus_of_its_kind_on_and_back(
    workstation: Preferences, wish: str, kind: str
) -> None:
    before = state(workstation)
    with use_device(context.scene, wish) as name:
        assert name == kind
        assert context.scene.cycles.device == "GPU"
        assert workstation.compute_device_type == kind
        on = {device.id for device in workstation.devices if device.use and device.type == kind}
        assert on == {f"{kind}_0", f"{kind}_1"}
    assert state(workstation) == before


def test_preferences_come_back_after_an_error(workstation: Preferences) -> None:
    before = state(workstation)
    with pytest.raises(ZeroDivisionError), use_device(context.scene, "cuda"):
        raise ZeroDivisionError
    assert state(workstation) == before


@pytest.mark.parametrize("wish", ["optix", "hip", "metal", "gpu", "none", "toaster", ""])
def test_a_device_that_is_not_there_is_refused_by_name(wish: str, monkeypatch: pytest.MonkeyPatch) -> None:
    bare = Preferences([Device("CPU", "CPU")])
    monkeypatch.setattr(module, "_cycles_preferences", lambda: bare)
    with pytest.raises(InputError, match=f"no device '{wish}' for Cycles: choose auto, or cpu") as raised:
        use_device(context.scene, wish).__enter__()
    assert raised.value.exit_code == 2
    assert state(bare) == ("NONE", [])


def test_without_cycles_the_message_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    bpy.ops.preferences.addon_disable(module="cycles")
    try:
        with pytest.raises(InputError, match="Cycles is switched off: enable"):
            use_device(context.scene, "auto").__enter__()
    finally:
        bpy.ops.preferences.addon_enable(module="cycles")
