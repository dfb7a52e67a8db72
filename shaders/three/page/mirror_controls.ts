// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The mirror ball's buttons, and dragging it where a drag beside it orbits.

import { Plane, Raycaster, Vector2, Vector3 } from "three";

import { element } from "./elements";
import type { Viewer } from "./viewer";

export class MirrorControls {
  constructor(
    private readonly viewer: Viewer,
    change: (act: () => void) => void,
  ) {
    if (!viewer.manifest.mirror) return;
    element("mirror").addEventListener("click", () => change(() => this.toggle()));
    this.followDrag(change);
  }

  /** Offer what there is to do, now that the ball is there. */
  complete(): void {
    for (const id of ["mirror", "mirror-gesture", "mirror-keys"]) element(id).hidden = !this.viewer.mirror;
  }

  /** Show the ball, or take it away. */
  toggle(): void {
    const { mirror } = this.viewer;
    if (mirror) this.viewer.setMirror({ shown: !mirror.state.shown });
  }

  /** Let the ball go on by itself, or stand. */
  toggleMotion(): void {
    const { mirror } = this.viewer;
    if (mirror) this.viewer.setMirror({ moving: !mirror.state.moving });
  }

  /** Have the button say what is so. */
  sync(): void {
    element("mirror").setAttribute("aria-pressed", String(this.viewer.mirror?.state.shown ?? false));
  }

  private followDrag(change: (act: () => void) => void): void {
    const { viewer } = this;
    const canvas = viewer.renderer.domElement;
    const plane = new Plane();
    const offset = new Vector3();
    let pointer: number | null = null;
    const under = (event: PointerEvent): Raycaster => {
      const box = canvas.getBoundingClientRect();
      const [x, y] = [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
      const caster = new Raycaster();
      caster.setFromCamera(new Vector2(2 * x - 1, 1 - 2 * y), viewer.camera);
      return caster;
    };
    // Before the canvas hears of it, whose other listeners orbit and inspect.
    viewer.stage.addEventListener(
      "pointerdown",
      (event) => {
        const ball = viewer.mirror;
        if (!ball?.visible || event.target !== canvas || event.button !== 0 || event.shiftKey) return;
        const [hit] = under(event).intersectObjects([ball, ...viewer.meshes], false);
        if (hit?.object !== ball) return;
        event.stopPropagation();
        canvas.setPointerCapture(event.pointerId);
        pointer = event.pointerId;
        plane.setFromNormalAndCoplanarPoint(viewer.camera.getWorldDirection(new Vector3()), hit.point);
        offset.subVectors(ball.position, hit.point);
      },
      { capture: true },
    );
    canvas.addEventListener("pointermove", (event) => {
      if (event.pointerId !== pointer) return;
      const place = under(event).ray.intersectPlane(plane, new Vector3());
      if (place) change(() => viewer.setMirror({ place: place.add(offset).toArray() }));
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
      canvas.addEventListener(end, () => (pointer = null));
    }
  }
}
