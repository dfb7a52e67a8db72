# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
@tool
extends Texture2DArray
## A texture array that scenes can be saved with: Godot asks the graphics card for its images then, and an import without a
## window has no card.

@export var images: Array[Image]:  ## Kept by the editor alone.
	set(value):
		if not value.is_empty():
			create_from_images(value)
		if Engine.is_editor_hint():
			images = value


func _validate_property(property: Dictionary) -> void:
	if property.name == "_images":
		property.usage = PROPERTY_USAGE_NONE
