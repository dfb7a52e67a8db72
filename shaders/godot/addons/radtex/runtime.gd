# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: MIT
extends Node
## Autoload: while the game runs, GLTFDocument.append_from_file reads what RadTex exports.

const Importer := preload("importer.gd")

var _importer := Importer.new()


func _enter_tree() -> void:
	GLTFDocument.register_gltf_document_extension(_importer, true)


func _exit_tree() -> void:
	GLTFDocument.unregister_gltf_document_extension(_importer)
