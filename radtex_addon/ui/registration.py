# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Register all classes and handlers when the extension is enabled; unregister in reverse order."""

from __future__ import annotations

from typing import Any

import bpy

from .jobs import estimates, jobs
from .operators import apply_operators, farm_operators, keys, texels_operator
from .operators.bake_operator import RADTEX_OT_bake
from .operators.browser_operator import RADTEX_OT_show_in_browser
from .operators.changes_operator import RADTEX_OT_dismiss_changes, RADTEX_OT_show_changes
from .operators.delete_operator import RADTEX_OT_delete_bake
from .operators.estimate_operator import RADTEX_OT_cancel_estimate, RADTEX_OT_estimate
from .operators.export_operator import RADTEX_OT_forget_export
from .operators.instances_operator import RADTEX_OT_join_instances
from .operators.job_operators import (
    RADTEX_OT_cancel,
    RADTEX_OT_cancel_here,
    RADTEX_OT_clear_jobs,
    RADTEX_OT_copy_report,
    RADTEX_OT_fold_job,
    RADTEX_OT_fold_map,
    RADTEX_OT_fold_warnings,
    RADTEX_OT_go_on,
    RADTEX_OT_open_folder,
    RADTEX_OT_show_jobs,
    RADTEX_OT_tell_end,
)
from .operators.remedy_operator import RADTEX_OT_apply_remedy, RADTEX_OT_fix_scale
from .operators.scene_operator import RADTEX_OT_bake_scene
from .operators.texels_operator import RADTEX_OT_show_texels
from .panel import finished_panel, forecast, job_ends, list_panel, menus, panel_state
from .panel.cost_panel import RADTEX_PT_cost
from .panel.farm_panel import RADTEX_PT_farm
from .panel.jobs_panel import RADTEX_PT_jobs
from .panel.main_panel import RADTEX_PT_bake
from .panel.settings_panels import (
    RADTEX_PT_light,
    RADTEX_PT_output,
    RADTEX_PT_sampling,
    RADTEX_PT_surface,
)
from .settings import preferences, presets, seen_version
from .settings.bake_settings import RADTEX_PG_settings
from .settings.chosen_bakes import RADTEX_PG_chosen_bake
from .settings.chosen_objects import RADTEX_PG_chosen, RADTEX_PG_listed
from .settings.kept_exports import RADTEX_PG_kept_export
from .settings.object_settings import RADTEX_PG_object
from .settings.preferences import RADTEX_preferences
from .settings.presets import RADTEX_OT_preset_add, RADTEX_OT_preset_apply, RADTEX_PT_presets

_scene: Any = bpy.types.Scene  # the stubs lack our properties
_object: Any = bpy.types.Object
_props: Any = bpy.props  # the 4.5 stubs type property functions as returning None

CLASSES = (
    RADTEX_preferences,
    RADTEX_PG_settings,
    RADTEX_PG_object,
    RADTEX_PG_listed,
    RADTEX_PG_chosen,
    RADTEX_PG_kept_export,
    RADTEX_PG_chosen_bake,
    RADTEX_OT_bake,
    RADTEX_OT_bake_scene,
    RADTEX_OT_join_instances,
    RADTEX_OT_show_texels,
    RADTEX_OT_apply_remedy,
    RADTEX_OT_fix_scale,
    RADTEX_OT_estimate,
    RADTEX_OT_cancel_estimate,
    RADTEX_OT_cancel,
    RADTEX_OT_cancel_here,
    RADTEX_OT_clear_jobs,
    RADTEX_OT_copy_report,
    RADTEX_OT_fold_job,
    RADTEX_OT_fold_map,
    RADTEX_OT_fold_warnings,
    RADTEX_OT_go_on,
    RADTEX_OT_open_folder,
    RADTEX_OT_tell_end,
    RADTEX_OT_show_jobs,
    RADTEX_OT_show_changes,
    RADTEX_OT_dismiss_changes,
    RADTEX_OT_show_in_browser,
    *apply_operators.CLASSES,
    RADTEX_OT_delete_bake,
    RADTEX_OT_forget_export,
    *farm_operators.CLASSES,
    RADTEX_OT_preset_add,
    RADTEX_OT_preset_apply,
    RADTEX_PT_presets,
    RADTEX_PT_bake,
    *list_panel.CLASSES,
    RADTEX_PT_jobs,  # right below the button, where users look after pressing it
    RADTEX_PT_light,
    RADTEX_PT_surface,
    RADTEX_PT_sampling,
    RADTEX_PT_output,
    RADTEX_PT_cost,
    RADTEX_PT_farm,
    *finished_panel.CLASSES,
    *menus.CLASSES,
)


def register() -> None:
    """Register every class in order, then the scene's settings, presets, key bindings and handlers."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    _scene.radtex = _props.PointerProperty(type=RADTEX_PG_settings)
    _scene.radtex_chosen = _props.PointerProperty(type=RADTEX_PG_chosen)
    _scene.radtex_exports = _props.CollectionProperty(type=RADTEX_PG_kept_export)
    _scene.radtex_chosen_bakes = _props.CollectionProperty(type=RADTEX_PG_chosen_bake)
    _object.radtex = _props.PointerProperty(type=RADTEX_PG_object)
    presets.register()
    keys.register()
    menus.register()
    job_ends.register()
    preferences.register()
    panel_state.register(forecast.compute_forecast)
    seen_version.register()
    jobs.register()


def unregister() -> None:
    """Undo `register`, in reverse order."""
    texels_operator.hide()
    panel_state.unregister()
    estimates.unregister()
    jobs.unregister()
    preferences.unregister()
    job_ends.unregister()
    menus.unregister()
    keys.unregister()
    presets.unregister()
    del _object.radtex
    del _scene.radtex_chosen_bakes
    del _scene.radtex_exports
    del _scene.radtex_chosen
    del _scene.radtex
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
