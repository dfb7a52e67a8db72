#!/bin/bash
# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# bash slurm.sh [OPTION OF SBATCH ...]
# WORK="python /opt/radtex/bake.py work" ASSEMBLE="python /opt/radtex/bake.py assemble" \
#     bash slurm.sh --partition=render --cpus-per-task=8
#
# Submits all tasks of this folder that are not done, as arrays, each of which waits for those that it needs. If some
# fail, what needs them is cancelled: run this again when no job of it is left, and it submits what is left.
# The options go to each sbatch, and replace the limits of memory and time that this file gives.
#
# WORK: what does a task, to which the folder and the task's name are added.
# BLENDER: where there are frames for machines without RadTex what renders them, such as blender.
# ASSEMBLE: what joins the bakes in the end, to which the folder is added; empty leaves that to you.
# None can have spaces in its paths.
set -euo pipefail

if [ "${1:-}" = --step ]; then # Slurm runs a task
    wanted="$2" folder="$3" command="$4"
else
    wanted=""
    folder="$(cd "$(dirname "$0")" && pwd)"
    script="$folder/$(basename "$0")"
    options=("$@")
    jobs=()
    submitted=0
    doing="${WORK:-python bake.py work}"
    renders="${BLENDER:-blender}"
    mkdir -p "$folder/logs"
fi

# Submit the array of a step: its number and name, MiB, minutes, the numbers of the steps that it needs, its tasks.
# Of a step that Slurm runs, do the task that is the array's element.
step() {
    local number="$1" name="$2" memory="$3" minutes="$4" needs="$5" left="" index=0 task file does="${doing:-}"
    shift 5
    if [ -n "$wanted" ]; then
        [ "$number" = "$wanted" ] || return 0
        shift "$SLURM_ARRAY_TASK_ID"
        echo "task $1 on $HOSTNAME"
        case "$1" in
        frames/*) render "$1" ;;
        *) exec $command "$folder" "$1" ;;
        esac
    fi
    for task in "$@"; do
        case "$task" in
        frames/*) does="$renders" file="$task" ;;
        *) file="done/$task.json" ;;
        esac
        [ -s "$folder/$file" ] || left="$left,$index"
        index=$((index + 1))
    done
    [ -n "$left" ] || return 0
    submit "$number" "$name" "$memory" "$minutes" "$needs" "$does" "--array=${left#,}"
}

# Render the frame with that picture.
render() {
    local picture="$folder/$1" number="$(basename "$1" .exr)"
    # Blender ends well where a frame was not rendered: so there is none before, and one afterwards.
    rm -f "$picture"
    $command -b "$(dirname "$picture").blend" -f "$((10#$number))"
    [ -s "$picture" ] || { echo "not rendered: $picture" >&2; exit 1; }
    exit
}

# Submit joining the bakes: MiB, and the numbers of the steps that it needs.
assemble() {
    if [ "$wanted" = assemble ]; then
        exec $command "$folder"
    fi
    [ -z "$wanted" ] && [ -n "${ASSEMBLE:-}" ] || return 0
    submit assemble assemble "$1" 240 "$2" "$ASSEMBLE"
}

submit() {
    local number="$1" name="$2" memory="$3" minutes="$4" needs="$5" command="$6" array="${7:-}" after="" need job
    local output="$folder/logs/%x-%j.out"
    [ -z "$array" ] || output="$folder/logs/%x-%A_%a.out"
    for need in $needs; do
        [ -z "${jobs[need]:-}" ] || after="$after:${jobs[need]}"
    done
    job="$(sbatch --parsable --job-name="$name" --mem="${memory}M" --time="$minutes" --output="$output" \
        ${array:+"$array"} ${after:+"--dependency=afterok$after" --kill-on-invalid-dep=yes} \
        ${options[@]+"${options[@]}"} "$script" --step "$number" "$folder" "$command")" || {
        echo "slurm.sh: sbatch refused $name; what was submitted goes on: run this again when it has ended" >&2
        exit 1
    }
    [ -z "$array" ] || jobs[number]="${job%%;*}"
    submitted=$((submitted + 1))
    echo "$name: job ${job%%;*}"
}

@STEPS@
assemble @LAST@

if [ -z "$wanted" ] && [ "$submitted" = 0 ]; then
    echo "All tasks are done. Join them: python bake.py assemble $(printf %q "$folder")"
fi
