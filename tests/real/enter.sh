# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# enter.sh ROOT SHARED REPOSITORY FOLDER COMMAND... executes a command in a root, in FOLDER, from within a mount and
# pid namespace of its own (root.py makes it). Without SHARED it runs as the root's administrator, who may write.
root=$1 shared=$2 repository=$3 folder=$4; shift 4
set -e
mount --bind "$root" "$root"
if [ -n "$shared" ]; then
    mount --bind "$shared" "$root/shared"
    mount --bind "$repository" "$root/repository"
    mount -o remount,ro,bind "$root/repository"
    mount -o remount,ro,bind "$root"
    for private in tmp run root; do mount -t tmpfs tmpfs "$root/$private"; done
    mkdir -m 1777 "$root/tmp/.X11-unix"
fi
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount -t tmpfs tmpfs "$root/dev/shm"
set +e
chroot "$root" /bin/sh -c 'cd "$0" && exec "$@"' "$folder" "$@"
exit $?
