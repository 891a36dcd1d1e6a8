// The sum of all motions of the pointer since a moment, in CSS pixels. No motion is lost: events that the
// browser has joined are taken one by one, and events come as soon as the browser has them, not once a
// frame, where it can.

import { movement_px, takeWindowWay, type Way } from "./capture.ts";
import type { Input } from "./live_protocol.ts";

const kRounding_px = 2; // of the way of a window, which is whole pixels
const kLeastWay_px = 10; // shorter ones are as long as motions of a mouse

export class PointerSum {
  private right = 0;
  private up = 0;
  private wasPressed = false; // since reset()
  private buttonIsDown = false; // the main one of a mouse
  private keyIsDown = false;
  private way: Way | null = null; // of the window, which may be in the next motion of the mouse
  private pressed: { id: number; x: number; y: number } | null = null; // pen or finger

  // board: the pointer moves nothing.
  input: Input = "mouse";
  // Whether button and key of a mouse are a clutch.
  permitsClutch = false;

  // surface: where pen and finger press; a mouse is locked. changed: called after each motion and press.
  constructor(private readonly surface: HTMLElement, private readonly changed: () => void) {
    const motion = "onpointerrawupdate" in window ? "pointerrawupdate" : "pointermove";
    document.documentElement.addEventListener(motion, (event) => this.move(event as PointerEvent));
    surface.addEventListener("pointerdown", (event) => this.press(event));
    for (const type of ["pointerdown", "pointerup"] as const) {
      document.documentElement.addEventListener(type, (event) => this.takeButton(event));
    }
    for (const end of ["pointerup", "pointercancel"] as const) {
      surface.addEventListener(end, (event) => this.release(event));
    }
  }

  reset(): void {
    this.right = this.up = 0;
    this.wasPressed = this.pressed !== null;
    this.buttonIsDown = this.keyIsDown = false;
    const way = takeWindowWay();
    if (way) this.way = Math.hypot(way.x, way.y) < kLeastWay_px ? null : way;
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

  // Whether the hand is set back: a pen or finger is lifted, or the clutch of a mouse is held.
  get isClutched(): boolean {
    if (this.input !== "mouse") return this.wasPressed && this.pressed === null;
    return this.holds && this.permitsClutch && (this.buttonIsDown || this.keyIsDown);
  }

  // The key that is a clutch beside the main button of a mouse.
  setKey(isDown: boolean): void {
    if (isDown === this.keyIsDown) return;
    this.keyIsDown = isDown;
    this.changed();
  }

  private takeButton(event: PointerEvent): void {
    const isDown = (event.buttons & 1) !== 0;
    if (this.input !== "mouse" || isDown === this.buttonIsDown) return;
    this.buttonIsDown = isDown;
    this.changed();
  }

  private move(event: PointerEvent): void {
    if (this.input === "mouse" ? document.pointerLockElement === null : event.pointerId !== this.pressed?.id) {
      return;
    }
    this.takeButton(event); // also of a second button
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
      const { x, y } = this.motionOf(part);
      this.right += movement_px() * x;
      this.up -= movement_px() * y;
    }
  }

  // If a window moves while it locks the pointer, Chromium may add its way to motions of the mouse: once backwards,
  // and then forwards to the first motion. Such motions are told by their length, and go without it.
  private motionOf({ movementX: x, movementY: y }: PointerEvent): Way {
    const { way } = this;
    if (!way || (x === 0 && y === 0)) return { x, y };
    if (Math.hypot(x + way.x, y + way.y) <= kRounding_px) return { x: 0, y: 0 };
    this.way = null;
    const isForth = Math.hypot(x - way.x, y - way.y) < 0.5 * Math.hypot(way.x, way.y);
    return isForth ? { x: x - way.x, y: y - way.y } : { x, y };
  }

  private press(event: PointerEvent): void {
    if (this.pressed || event.pointerType !== this.input || this.input === "mouse") return;
    this.surface.setPointerCapture(event.pointerId);
    this.pressed = { id: event.pointerId, x: event.clientX, y: event.clientY };
    this.wasPressed = true;
    this.changed();
  }

  private release(event: PointerEvent): void {
    if (event.pointerId !== this.pressed?.id) return;
    if (event.type === "pointerup") this.add(event); // the way since its last motion; a cancel has no place
    this.pressed = null;
    this.changed();
  }
}
