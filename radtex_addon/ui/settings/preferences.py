# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add-on preferences: device, folders, memory limit, exports, what new files start from, and help."""

from __future__ import annotations

import logging
import tomllib
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.app.handlers import persistent
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty

from ...core.errors import InputError
from ...settings.menu_items import DEVICES, TARGETS
from ...settings.presets import STOCK
from ...settings.targets import DEFAULT_TARGET
from ..panel.fitting import draw_text
from ..panel.labels import iface_
from .bake_settings import NAMES
from .presets import apply_preset

# "bl_ext.user_default.radtex" when installed as an extension.
ADDON = __package__.rpartition(".radtex_addon")[0] or "radtex_addon"
MANIFEST = Path(__file__).parents[3] / "blender_manifest.toml"  # ships in the zip
_GIVEN_MB = 8192  # memory limit at first, where the machine does not say how much it has
_PLACEHOLDERS = {  # what is used where a folder is left empty
    "output_folder": "None: the panel asks for one",
    "cache_folder": "The extension's own folder",
    "export_into": "Beside each bake",
}
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Preferred:
    """The preferences' values; folders and the memory limit are None if not set, `preset` is empty.

    `export_into` is a folder as the user wrote it, empty for one beside each bake.
    """

    device: str = "auto"
    output: Path | None = None
    cache: Path | None = None
    memory_mb: int | None = None
    preset: str = ""
    export_target: str = DEFAULT_TARGET.value
    export_into: str = ""
    notify: bool = True


def _has_limit(preferences: RADTEX_preferences) -> bool:
    return preferences.memory_mb > 0


def _set_limit(preferences: RADTEX_preferences, on: bool) -> None:
    """Switch the memory limit on, at half of the machine's memory, or off."""
    from ...formats.disk.memory import physical_memory

    found = physical_memory()
    half = _GIVEN_MB if found is None else max(found // 2**21, 1)
    preferences.memory_mb = half if on else 0


class RADTEX_preferences(bpy.types.AddonPreferences):
    """RadTex's preferences"""

    bl_idname = ADDON

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        device: str
        output_folder: str
        cache_folder: str
        memory_mb: int
        limits_memory: bool
        default_preset: str
        export_target: str
        export_into: str
        notify: bool
        seen_version: str
    else:
        device: EnumProperty(
            name="Device",
            description="What traces the paths. Pictures differ in their noise only",
            items=DEVICES,
            default="auto",
        )
        output_folder: StringProperty(
            name="Output Folder",
            description="Where bakes of files go that were never saved, and so have no folder of their own",
            subtype="DIR_PATH",
        )
        cache_folder: StringProperty(
            name="Cache Folder",
            description="Where the scene waits while it is baked: as much room as the .blend takes. Left "
            "empty, the extension's own folder",
            subtype="DIR_PATH",
        )
        memory_mb: IntProperty(
            name="Memory (MB)",
            description="What a bake may take beside the scene: one that needs more is refused, less renders "
            "smaller tiles of the same picture. 0 is as much as the machine has",
            default=0,
            min=0,
            max=2**24,
            soft_max=16384,
        )
        limits_memory: BoolProperty(
            name="Limit Memory",
            description="Refuse bakes that need more memory beside the scene than this. Off, a bake may take "
            "what the machine has",
            get=_has_limit,
            set=_set_limit,
        )
        default_preset: EnumProperty(
            name="Default Preset",
            description="What new files start from",
            items=(("none", "None", "RadTex's own defaults"), *STOCK),
            default="none",
        )
        export_target: EnumProperty(
            name="Export To",
            description="What the export dialog starts with: the target that was last chosen there",
            items=TARGETS,
            default=DEFAULT_TARGET.value,
        )
        export_into: StringProperty(
            name="Export Into",
            description="Where the export dialog makes folders: what was last chosen there. Left empty, "
            "beside each bake",
            subtype="DIR_PATH",
        )
        notify: BoolProperty(
            name="Tell When Done",
            description="Say in the status bar when bakes, exports and comparisons have ended, and in the 3D "
            "view's header until it is clicked, also while the sidebar is hidden",
            default=True,
        )
        seen_version: StringProperty(
            name="Version Seen",
            description="The version whose changes were shown or dismissed last",
            options={"HIDDEN"},
        )

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        text = iface_("To bake, press N over a 3D view and open the sidebar's tab RadTex")
        draw_text(layout, text, "INFO")
        layout.use_property_split = True
        layout.prop(self, "device")
        draw_memory(layout, self)
        for name in ("output_folder", "cache_folder", "default_preset", "export_target", "export_into"):
            layout.prop(self, name, placeholder=iface_(_PLACEHOLDERS.get(name, "")))
        layout.prop(self, "notify")
        draw_links(layout)


def draw_memory(layout: Any, preferences: RADTEX_preferences) -> None:
    """Draw the memory limit: a switch, and how much may be taken while it is on."""
    row = layout.row(align=True, heading=iface_("Memory (MB)"))
    row.prop(preferences, "limits_memory", text="")
    if preferences.limits_memory:
        row.prop(preferences, "memory_mb", text="")
    else:
        row.label(text=iface_("Automatic"), translate=False)


def draw_links(layout: Any) -> None:
    """Draw the buttons for help: what a report needs, what is new, and the website if there is one."""
    layout.operator("radtex.copy_report", text="Copy System Information", icon="COPYDOWN")
    layout.operator("radtex.show_changes", icon="INFO")
    if url := website():
        layout.operator("wm.url_open", text="Manual and Reports", icon="URL").url = url


@lru_cache
def website() -> str:
    """Where the manual is and faults are reported: the manifest's website; empty if it names none."""
    try:
        return str(tomllib.loads(MANIFEST.read_text(encoding="utf-8")).get("website", ""))
    except (OSError, tomllib.TOMLDecodeError):  # of a copy that was taken apart
        return ""


def preferred() -> Preferred:
    """The current preferences; defaults if RadTex is not installed as an add-on."""
    found = addon_preferences()
    if found is None:
        return Preferred()
    return Preferred(
        device=found.device,
        output=_folder(found.output_folder),
        cache=_folder(found.cache_folder),
        memory_mb=found.memory_mb or None,
        preset="" if found.default_preset == "none" else found.default_preset,
        export_target=found.export_target,
        export_into=found.export_into,
        notify=found.notify,
    )


def remember_export(target: str, into: str) -> None:
    """Let the next export dialog start with these, in new files and later sessions, too."""
    found = addon_preferences()
    if found is None or (found.export_target, found.export_into) == (target, into):
        return
    found.export_target, found.export_into = target, into
    assert bpy.context.preferences is not None  # only restricted contexts have none
    bpy.context.preferences.is_dirty = True  # so that Blender saves them at its end


def addon_preferences() -> RADTEX_preferences | None:
    """The preferences; None if RadTex is not installed as an add-on."""
    assert bpy.context.preferences is not None  # only restricted contexts have none
    addon = bpy.context.preferences.addons.get(ADDON)
    if addon is None or addon.preferences is None:
        return None
    return cast(RADTEX_preferences, addon.preferences)


def _folder(text: str) -> Path | None:
    return Path(bpy.path.abspath(text)) if text.strip() else None


@persistent  # type: ignore[untyped-decorator]  # untyped in the stubs
def apply_default(*_: object) -> None:
    """Handler: apply the default preset to a new file's scene, unless any setting was already changed."""
    name = preferred().preset
    settings = bpy.context.scene.radtex  # type: ignore[union-attr]  # ours, not Blender's
    if bpy.data.filepath or not name or any(settings.is_property_set(one) for one in NAMES):
        return
    try:
        apply_preset(name)
    except InputError as error:  # the file is loaded anyway, so only warn
        _log.warning("%s", error)


def register() -> None:
    """Add the load handler."""
    bpy.app.handlers.load_post.append(apply_default)


def unregister() -> None:
    """Remove the load handler."""
    if apply_default in bpy.app.handlers.load_post:  # other add-ons may have cleared the list
        bpy.app.handlers.load_post.remove(apply_default)
