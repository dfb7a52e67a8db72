// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Compiles a job by a Flamenco job type, as Flamenco's Manager does, and prints its tasks:
// node flamenco.js JOB_TYPE.js SETTINGS. A small stand-in for what Manager gives to scripts.

const { readFileSync } = require("node:fs");
const path = require("node:path");
const vm = require("node:vm");

const [, , file, settings] = process.argv;

class Task {
    constructor(name, type) {
        Object.assign(this, { name, type, commands: [], dependencies: [] });
    }
    addCommand(command) {
        this.commands.push(command);
    }
    addDependency(task) {
        this.dependencies.push(task.name);
    }
}

// "1-5,8" by twos: "1-2", "3-4", "5,8".
function frameChunker(frames, size) {
    const single = frames.split(",").flatMap((run) => {
        const [first, last = first] = run.trim().split("-").map(Number);
        return Array.from({ length: last - first + 1 }, (_, k) => first + k);
    });
    const chunks = [];
    for (let start = 0; start < single.length; start += size) {
        chunks.push(listed(single.slice(start, start + size)));
    }
    return chunks;
}

function listed(frames) {
    const runs = [];
    for (const frame of frames) {
        const last = runs.at(-1);
        if (last && last[1] === frame - 1) last[1] = frame;
        else runs.push([frame, frame]);
    }
    return runs.map(([first, last]) => (first === last ? `${first}` : `${first}-${last}`)).join(",");
}

const author = {
    Task: (name, type) => new Task(name, type),
    Command: (name, parameters) => ({ name, parameters }),
};
const context = vm.createContext({ author, frameChunker, path: path.posix, print: () => {} });
const script = `${readFileSync(file, "utf8")}\n;({ JOB_TYPE, compileJob })`;
const { JOB_TYPE, compileJob } = vm.runInContext(script, context, { filename: file });
const tasks = [];
const given = JSON.parse(settings);
const filled = Object.fromEntries(JOB_TYPE.settings.map(({ key, default: value }) => [key, given[key] ?? value]));
compileJob({ settings: filled, addTask: (task) => tasks.push(task) });
process.stdout.write(JSON.stringify({ type: JOB_TYPE, tasks }));
