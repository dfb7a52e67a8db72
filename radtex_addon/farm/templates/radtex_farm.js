// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco 3: put this file into the Manager's folder scripts/, open farm.blend in Blender, and submit it with
// the job type "RadTex farm". Every frame is a sheet of the bake; pictures go where the file says, frames/.

const JOB_TYPE = {
    label: "RadTex farm",
    description: "Render the sheets of a radiance texture, and join them if asked to",
    settings: [
        { key: "frames", type: "string", required: true,
          eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
          description: "Frames to render, such as 1-20 or 3,7-9" },
        { key: "chunk_size", type: "int32", default: 1, visible: "submission",
          description: "Frames that one task renders" },
        { key: "assemble", type: "string", required: false, default: "", visible: "submission",
          description: "Program that joins the frames, such as /opt/radtex/assemble: it is called with the farm's folder. Empty: none" },
        { key: "blendfile", type: "string", required: true, visible: "web",
          description: "The farm.blend, as workers see it" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const renders = frameChunker(settings.frames, settings.chunk_size).map((chunk) => {
        const task = author.Task(`sheets-${chunk}`, "blender");
        task.addCommand(author.Command("blender-render", {
            exe: "{blender}",
            exeArgs: "{blenderArgs}",
            argsBefore: [],
            blendfile: settings.blendfile,
            args: ["--render-frame", chunk.replace(/-/g, "..")],
        }));
        job.addTask(task);
        return task;
    });
    if (!settings.assemble) {
        return;
    }
    const joined = author.Task("assemble", "misc");
    joined.addCommand(author.Command("exec", {
        exe: settings.assemble,
        args: [path.dirname(settings.blendfile)],
    }));
    for (const render of renders) {
        joined.addDependency(render);
    }
    job.addTask(joined);
}
