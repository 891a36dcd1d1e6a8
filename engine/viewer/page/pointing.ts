// Turns pointer, wheel and keys over the view into motions of the hand and of the camera.

import type { Display, DisplayMode } from "./display.ts";
import type { Hand, HandView } from "./pointer.ts";
import type { Vector3 } from "./protocol.ts";
import type { ViewCamera } from "./view_camera.ts";

const kKeyStep_px = 6;
const kTurnStep_px = 24;
const kDepthPerWheel = 0.25; // pixels of depth for each unit of the wheel
const kZoomPerWheel = 0.0015;

const kArrows: Record<string, readonly [right: number, up: number]> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

// What is pointed at. A drawing without a choice of its own ignores zoom and turns.
export interface PointedView {
  readonly camera: ViewCamera;
  readonly mode: DisplayMode;
  readonly lastDisplay: Display | null;
  zoomBy(factor: number): void;
  turnBy(right_px: number, up_px: number): void;
}

interface Place {
  x: number;
  y: number;
}

export class Pointing {
  private readonly pointers = new Map<number, Place>();
  private pressed: Hand | null = null; // the hand that the only pointer moves

  constructor(
    private readonly canvas: HTMLCanvasElement, private readonly view: PointedView,
    private readonly activeHand: () => Hand | null,
    private readonly devicePosition: () => readonly number[] | null,
  ) {
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", (event) => this.up(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  // An arrow key, or a key for depth. Returns true if it was one.
  key(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.altKey || event.metaKey) return false;
    const arrow = kArrows[event.key];
    if (arrow && event.shiftKey && !this.view.camera.isTopView) {
      this.view.turnBy(kTurnStep_px * arrow[0], kTurnStep_px * arrow[1]);
      return true;
    }
    const ahead = event.key === "PageUp" ? 1 : event.key === "PageDown" ? -1 : 0;
    if (!arrow && (ahead === 0 || this.view.camera.isTopView)) return false;
    const view = this.handView();
    const hand = this.activeHand();
    if (!view || !hand) return false;
    const [right, up] = arrow ?? [0, 0];
    hand.moveBy(view, kKeyStep_px * right, kKeyStep_px * up, kKeyStep_px * ahead);
    return true;
  }

  private handView(): HandView | null {
    const display = this.view.lastDisplay;
    const device_m = this.devicePosition();
    if (!display || !device_m) return null;
    return { camera: this.view.camera, mode: this.view.mode, display, device_m: device_m as Vector3 };
  }

  private down(event: PointerEvent): void {
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const turns = event.button !== 0 || (event.shiftKey && !this.view.camera.isTopView);
    if (this.pointers.size > 1 || turns) {
      this.endPress();
      return;
    }
    const view = this.handView();
    const hand = this.activeHand();
    if (!view || !hand) return;
    this.pressed = hand;
    hand.grasp(view);
    if (hand.isAbsolute(view)) this.press(hand, view, event);
  }

  private move(event: PointerEvent): void {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const right = event.clientX - last.x;
    const up = last.y - event.clientY;
    if (this.pointers.size === 2) this.pinch(event, last);
    last.x = event.clientX;
    last.y = event.clientY;
    if (!this.pressed) {
      this.view.turnBy(right / this.pointers.size, up / this.pointers.size);
      return;
    }
    const view = this.handView();
    const hand = this.activeHand();
    if (!view || !hand) return;
    this.pressed = hand; // another one after a new connection
    if (hand.isAbsolute(view)) this.press(hand, view, event);
    else hand.moveBy(view, right, up, 0);
  }

  private up(event: PointerEvent): void {
    this.pointers.delete(event.pointerId);
    this.endPress();
  }

  private endPress(): void {
    this.pressed?.letGo(); // also while paused
    this.pressed = null;
  }

  private press(hand: Hand, view: HandView, event: PointerEvent): void {
    const box = this.canvas.getBoundingClientRect();
    hand.moveTo(view, event.clientX - box.left - 0.5 * box.width,
                box.top + 0.5 * box.height - event.clientY);
  }

  // Two fingers: their distance zooms.
  private pinch(event: PointerEvent, last: Place): void {
    const other = [...this.pointers.values()].find((place) => place !== last);
    if (!other) return;
    const before = Math.hypot(last.x - other.x, last.y - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (before > 0 && after > 0) this.view.zoomBy(after / before);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    if (this.view.camera.isTopView || event.ctrlKey || event.shiftKey) {
      this.view.zoomBy(Math.exp(-kZoomPerWheel * (event.deltaY || event.deltaX)));
      return;
    }
    const view = this.handView();
    const hand = this.activeHand();
    if (view && hand) hand.moveBy(view, 0, 0, -kDepthPerWheel * event.deltaY);
  }
}
