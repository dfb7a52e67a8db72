// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Walking through a room: eyes at a person's height above the floor, keys to go, dragging to look around.

import { Box3, type Mesh, type PerspectiveCamera, Raycaster, Vector3 } from "three";

const EYES = 1.6; // metres above the floor
const CHEST = 0.9; // metres above the floor: what is there is in the way
const APART = 0.3; // metres from what is in the way
const RISE = 0.4; // metres that a step goes up
const SPEED = 1.5; // metres a second
const FASTER = 2.5; // times, with Shift
const TURN = 1.6; // radians a second, by keys
const SETTLING = 10; // per second: how fast eyes follow the floor
const DROP = 3; // metres that one goes down at once
const STEEPEST = 1.5; // radians up or down
const LONGEST = 0.1; // seconds that one frame moves for
const UP = new Vector3(0, 1, 0);
const DOWN = new Vector3(0, -1, 0);
const TRIED = 5; // places along each side, of which the most open one is where a walk begins
const AROUND = 12; // directions in which is asked how open a place is
const WALLS = 0.8; // share of them in which there is a wall, indoors
const LEVEL = 0.7; // least height of a floor's unit normal
const OPEN = 3; // metres: nobody needs more around

const WAYS = Array.from({ length: AROUND }, (_, turn) => {
  const angle = (turn / AROUND) * 2 * Math.PI;
  return new Vector3(-Math.sin(angle), 0, -Math.cos(angle));
});

/** What the keys that are held down do: [forwards, to the right, turn to the left]. */
const KEYS: Readonly<Record<string, readonly [number, number, number]>> = {
  KeyW: [1, 0, 0],
  ArrowUp: [1, 0, 0],
  KeyS: [-1, 0, 0],
  ArrowDown: [-1, 0, 0],
  KeyA: [0, -1, 0],
  KeyD: [0, 1, 0],
  ArrowLeft: [0, 0, 1],
  ArrowRight: [0, 0, -1],
};

export class Walk {
  private readonly held = new Set<string>();
  private readonly caster = new Raycaster();
  private readonly ending = new AbortController();
  private floor: number; // its height
  private across: number; // radians to the left of -z
  private up = 0;
  private before = 0; // milliseconds
  private fast = false;

  /** Begin where told, and follow keys and pointer until `end`. `moved` asks for a frame. */
  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly meshes: readonly Mesh[],
    { eyes, floor, across }: Standpoint,
    canvas: HTMLElement,
    private readonly moved: () => void,
  ) {
    this.floor = floor;
    this.across = across;
    camera.position.copy(eyes);
    const { signal } = this.ending;
    document.addEventListener("keydown", (event) => this.key(event, true), { signal });
    document.addEventListener("keyup", (event) => this.key(event, false), { signal });
    window.addEventListener("blur", () => this.held.clear(), { signal });
    canvas.addEventListener("pointermove", (event) => this.look(event, canvas), { signal });
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId), { signal });
    this.aim();
  }

  end(): void {
    this.ending.abort();
  }

  /** Stand at a place of the floor; refused where its normal (3) is no floor's. */
  stand(place: Vector3, normal: readonly number[]): boolean {
    if ((normal[1] ?? 0) < LEVEL) return false;
    this.floor = place.y;
    const { position } = this.camera;
    position.set(place.x, place.y + EYES, place.z);
    for (const way of WAYS) {
      const hit = this.first(position.clone().setY(place.y + CHEST), way, APART);
      if (hit) position.addScaledVector(way, hit.far - APART); // not with the nose at a wall
    }
    this.moved();
    return true;
  }

  /** Go on until now, in milliseconds; whether it goes on after this frame. */
  advance(now: number): boolean {
    const seconds = Math.min(LONGEST, (now - this.before) / 1000);
    this.before = now;
    const asked = [...this.held].map((code) => KEYS[code] ?? [0, 0, 0]);
    const sum = (axis: number): number => asked.reduce((total, way) => total + (way[axis] ?? 0), 0);
    const [forwards, right, turn] = [sum(0), sum(1), sum(2)];
    this.across += turn * TURN * seconds;
    const way = new Vector3(right, 0, -forwards).applyAxisAngle(UP, this.across);
    if (way.lengthSq() > 0) this.go(way.setLength(SPEED * (this.fast ? FASTER : 1) * seconds));
    const { position } = this.camera;
    const left = this.floor + EYES - position.y;
    const settled = Math.abs(left) < 1e-3;
    position.y += settled ? left : left * Math.min(1, SETTLING * seconds);
    this.aim();
    return this.held.size > 0 || !settled;
  }

  private key(event: KeyboardEvent, down: boolean): void {
    this.fast = event.shiftKey;
    if (!KEYS[event.code] || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLInputElement) return;
    event.preventDefault();
    if (down && !this.held.size) this.before = performance.now();
    if (down) this.held.add(event.code);
    else this.held.delete(event.code);
    this.moved();
  }

  private look(event: PointerEvent, canvas: HTMLElement): void {
    if (!(event.buttons & 1) || !event.isPrimary) return;
    const step = (this.camera.fov * Math.PI) / 180 / canvas.clientHeight;
    this.across += event.movementX * step;
    this.up = Math.min(STEEPEST, Math.max(-STEEPEST, this.up + event.movementY * step));
    this.aim();
    this.moved();
  }

  private aim(): void {
    this.camera.rotation.set(this.up, this.across, 0, "YXZ");
  }

  /** Move by a step along the floor, or along what is in the way. */
  private go(step: Vector3): void {
    const { position } = this.camera;
    for (const low of [CHEST, RISE]) {
      const from = new Vector3(position.x, this.floor + low, position.z);
      const hit = this.first(from, step.clone().normalize(), step.length() + APART);
      if (!hit) continue;
      const normal = hit.normal.setY(0).normalize();
      const against = step.dot(normal);
      if (against < 0) step.addScaledVector(normal, -against); // slide along it
    }
    const there = position.clone().add(step);
    if (this.first(new Vector3(position.x, this.floor + CHEST, position.z), step.clone().normalize(), step.length() + APART / 2)) {
      return; // a corner
    }
    const below = this.first(new Vector3(there.x, this.floor + CHEST, there.z), DOWN, CHEST + DROP);
    if (!below || below.place.y > this.floor + RISE) return; // nothing to stand on, or too high a step
    this.floor = below.place.y;
    position.x = there.x;
    position.z = there.z;
  }

  private first(from: Vector3, way: Vector3, far: number): Met | null {
    return firstMet(this.caster, this.meshes, from, way, far);
  }
}

/** Where a walk begins. */
export interface Standpoint {
  eyes: Vector3;
  /** The height of the floor. */
  floor: number;
  /** Radians to the left of -z. */
  across: number;
  /** Whether there are walls all around, and a ceiling. */
  indoors: boolean;
}

/** The most open place at a person's height, and the way there that is longest. */
export function standpointIn(meshes: readonly Mesh[]): Standpoint {
  const caster = new Raycaster();
  const box = meshes.reduce((whole, mesh) => whole.expandByObject(mesh), new Box3());
  const [size, middle] = [box.getSize(new Vector3()), box.getCenter(new Vector3())];
  const far = size.length();
  const at = (x: number, floor: number, z: number): Vector3 => new Vector3(x, floor + EYES, z);
  let best = -1;
  let found: Standpoint = { eyes: at(middle.x, box.min.y, middle.z), floor: box.min.y, across: 0, indoors: false };
  for (let place = 0; place < TRIED * TRIED; place++) {
    const x = box.min.x + ((Math.floor(place / TRIED) + 1) / (TRIED + 1)) * size.x;
    const z = box.min.z + (((place % TRIED) + 1) / (TRIED + 1)) * size.z;
    const below = firstMet(caster, meshes, new Vector3(x, middle.y, z), DOWN, size.y);
    if (!below?.front || below.normal.y < LEVEL) continue; // or inside something solid
    const chest = below.place.clone().setY(below.place.y + CHEST);
    const free = WAYS.map((way) => firstMet(caster, meshes, chest, way, far)?.far ?? far);
    const open = Math.min(OPEN, ...free) + 1e-3 * Math.max(...free);
    if (open <= best) continue;
    best = open;
    const eyes = at(x, below.place.y, z);
    const seen = WAYS.map((way) => {
      const met = firstMet(caster, meshes, eyes, way, far);
      return met?.front ? met.far : 0;
    });
    const longest = WAYS[seen.indexOf(Math.max(...seen))] as Vector3;
    const walls = seen.filter((length) => length > 0).length;
    const indoors = walls >= WALLS * WAYS.length && firstMet(caster, meshes, eyes, UP, far)?.front === true;
    found = { eyes, floor: below.place.y, across: Math.atan2(-longest.x, -longest.z), indoors };
  }
  return found;
}

interface Met {
  place: Vector3;
  normal: Vector3;
  far: number;
  /** Whether it is met from its front. */
  front: boolean;
}

/** What a ray of some length meets first; the normal faces where it comes from. */
function firstMet(caster: Raycaster, meshes: readonly Mesh[], from: Vector3, way: Vector3, far: number): Met | null {
  caster.set(from, way);
  caster.far = far;
  const [hit] = caster.intersectObjects<Mesh>([...meshes], false);
  if (!hit?.face) return null;
  const normal = hit.face.normal.clone().transformDirection(hit.object.matrixWorld);
  const front = normal.dot(way) < 0;
  return { place: hit.point, normal: front ? normal : normal.negate(), far: hit.distance, front };
}
