// The sum of all motions of the pointer since a moment, in CSS pixels. No motion is lost: events that the
// browser has joined are taken one by one, and events come as soon as the browser has them, not once a
// frame, where it can.

import { movement_px } from "./capture.ts";
import type { Input } from "./live_protocol.ts";

export class PointerSum {
  private right = 0;
  private up = 0;
  private pressed: { id: number; x: number; y: number } | null = null; // pen or finger

  // board: the pointer moves nothing.
  input: Input = "mouse";

  // surface: where pen and finger press; a mouse is locked. changed: called after each motion and press.
  constructor(private readonly surface: HTMLElement, private readonly changed: () => void) {
    const motion = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";
    document.documentElement.addEventListener(motion, (event) => this.move(event as PointerEvent));
    surface.addEventListener("pointerdown", (event) => this.press(event));
    for (const end of ["pointerup", "pointercancel"] as const) {
      surface.addEventListener(end, (event) => this.release(event));
    }
  }

  reset(): void {
    this.right = this.up = 0;
  }

  get right_px(): number {
    return this.right;
  }
  get up_px(): number {
    return this.up;
  }

  // Whether pen or finger is down, or the mouse is locked.
  get holds(): boolean {
    return this.input === "mouse" ? document.pointerLockElement !== null : this.pressed !== null;
  }

  private move(event: PointerEvent): void {
    if (this.input === "mouse" ? document.pointerLockElement === null : event.pointerId !== this.pressed?.id) {
      return;
    }
    const parts = event.getCoalescedEvents();
    for (const part of parts.length > 0 ? parts : [event]) this.add(part);
    this.changed();
  }

  private add(part: PointerEvent): void {
    if (this.pressed && this.input !== "mouse") {
      this.right += part.clientX - this.pressed.x;
      this.up -= part.clientY - this.pressed.y;
      this.pressed.x = part.clientX;
      this.pressed.y = part.clientY;
    } else {
      this.right += movement_px() * part.movementX;
      this.up -= movement_px() * part.movementY;
    }
  }

  private press(event: PointerEvent): void {
    if (this.pressed || event.pointerType !== this.input || this.input === "mouse") return;
    this.surface.setPointerCapture(event.pointerId);
    this.pressed = { id: event.pointerId, x: event.clientX, y: event.clientY };
    this.changed();
  }

  private release(event: PointerEvent): void {
    if (event.pointerId !== this.pressed?.id) return;
    if (event.type === "pointerup") this.add(event); // the way since its last motion; a cancel has no place
    this.pressed = null;
    this.changed();
  }
}
