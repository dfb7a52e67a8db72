// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco 3.3 or newer: put this file into the Manager's folder scripts/, open a farm's scene.blend in Blender where
// it lies in the shared storage, and submit it with the job type "RadTex tasks". Each task is one of tasks.json,
// beside the .blend, and waits for those that it needs. Frames for machines without RadTex are tasks, too, by
// the names of their pictures: workers render these by their own Blender.

const JOB_TYPE = {
    label: "RadTex tasks",
    description: "Bake radiance textures by the tasks that bake.py prepare wrote, and join them if asked to",
    settings: [
        { key: "work", type: "string", required: true, default: "python bake.py work", visible: "submission",
          description: "Command that does a task, such as python /opt/radtex/bake.py work: the farm's folder and the task's name are added" },
        { key: "assemble", type: "string", required: false, default: "", visible: "submission",
          description: "Command that joins the bakes, such as python /opt/radtex/bake.py assemble: the farm's folder is added. Empty: none" },
        { key: "folder", type: "string", required: true, visible: "web",
          eval: "str(Path(bpy.data.filepath).parent)",
          description: "The farm's folder, as workers see it" },
        // A line for each task: its name, and the names of those that it needs, and of their pictures.
        { key: "tasks", type: "string", required: true, visible: "hidden",
          eval: "'\\n'.join(' '.join([task['id'], *task['needs'], *task.get('pictures', [])]) for task in __import__('json').loads("
              + "Path(bpy.data.filepath).with_name('tasks.json').read_text(encoding='utf-8'))['tasks'])",
          description: "The farm's tasks" },
    ],
};

function compileJob(job) {
    const { work, assemble, folder, tasks } = job.settings;
    const made = {};
    const needed = {};
    for (const line of tasks.split("\n")) {
        const [name, ...needs] = line.split(" ");
        made[name] = command(name, "misc", work, [folder, name]);
        for (const need of needs) {
            if (!made[need]) {
                made[need] = frame(need, folder);
                job.addTask(made[need]);
            }
            made[name].addDependency(made[need]);
            needed[need] = true;
        }
        job.addTask(made[name]);
    }
    if (!assemble) {
        return;
    }
    const joined = command("assemble", "misc", assemble, [folder]);
    for (const name of Object.keys(made).filter((one) => !needed[one])) {
        joined.addDependency(made[name]);
    }
    job.addTask(joined);
}

// A task that renders the frame of a picture, such as frames/Vase.light/0001.exr.
function frame(picture, folder) {
    const [, blend, number] = picture.match(/^(.*)\/0*(\d+)\.exr$/);
    const task = author.Task(picture, "blender");
    task.addCommand(author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: [],
        blendfile: `${folder}/${blend}.blend`,
        args: ["--render-frame", number],
    }));
    return task;
}

// A task that runs a command line, with more arguments behind it.
function command(name, type, line, added) {
    const [exe, ...args] = words(line);
    const task = author.Task(name, type);
    task.addCommand(author.Command("exec", { exe, args: [...args, ...added] }));
    return task;
}

// 'python "/my tools/bake.py" work' as three words.
function words(line) {
    return (line.match(/"[^"]*"|'[^']*'|\S+/g) || []).map((word) => word.replace(/^(["'])(.*)\1$/, "$2"));
}
