# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
@tool
extends EditorPlugin
## Waits for a line of paths, has the editor import them, and says ANSWERED; again until there is no line.


func _enter_tree() -> void:
	serve.call_deferred()


func serve() -> void:
	var files := EditorInterface.get_resource_filesystem()
	var line := OS.read_string_from_stdin(65536).strip_edges()
	while line:
		for path: String in line.split(" "):
			while files.is_scanning() or not ResourceLoader.exists(path):
				if not files.is_scanning():
					files.scan()
				await get_tree().process_frame
		print("ANSWERED")
		line = OS.read_string_from_stdin(65536).strip_edges()
	get_tree().quit()
