// The hand: drags, the wheel and the arrow keys move the target of the simulated hand.

import { Vector3 } from "three";

import type { Display, DisplayMode } from "./display.ts";
import type { Hello, Vector3 as Numbers } from "./protocol.ts";
import type { ViewCamera } from "./view_camera.ts";

export const kRepeat_ms = 50; // the server lets go after 300 ms without a message

// What the hand needs to know about the view.
export interface HandView {
  camera: ViewCamera;
  mode: DisplayMode;
  display: Display;
  device_m: Numbers; // sensed position
}

// The target of the hand. The caller sends what `send` gets.
export class Hand {
  private target_m = new Vector3();
  private held = false;
  private timer = 0;

  constructor(
    private readonly hello: Hello,
    private readonly send: (target_m: Numbers, isHeld: boolean) => void,
  ) {}

  get isHeld(): boolean {
    return this.held;
  }

  // In the classical top view the target is where the pointer is. Otherwise an absolute place would
  // run away, and the target moves by the pointer's displacement.
  isAbsolute(view: HandView): boolean {
    return view.camera.isTopView && view.mode === "classical";
  }

  grasp(view: HandView): void {
    if (!this.held) this.target_m.fromArray(view.device_m);
    this.held = true;
    this.sendNow();
  }

  // Moves the target to a place of the top view, in pixels from the middle of the view.
  moveTo(view: HandView, right_px: number, up_px: number): void {
    const { camera } = view;
    const pixel_m = camera.metresPerPixel(camera.camera.position);
    const place = camera.camera.position.clone()
      .addScaledVector(camera.right, right_px * pixel_m)
      .addScaledVector(camera.upward, up_px * pixel_m)
      .sub(view.display.T_display_device);
    this.place(new Vector3(place.x, place.y, this.target_m.z));
  }

  // Moves the target by a displacement along the axes of the view, in pixels.
  moveBy(view: HandView, right_px: number, up_px: number, ahead_px: number): void {
    this.graspQuietly(view);
    const { camera } = view;
    const seen = this.target_m.clone().add(view.display.T_display_device);
    const pixel_m = camera.metresPerPixel(seen);
    const move = new Vector3()
      .addScaledVector(camera.right, right_px * pixel_m)
      .addScaledVector(camera.upward, up_px * pixel_m)
      .addScaledVector(camera.ahead, ahead_px * pixel_m);
    if (this.hello.device.sensors === 2) move.z = 0; // A3 is not sensed
    this.place(this.target_m.clone().add(move));
  }

  letGo(): void {
    if (!this.held) return;
    this.held = false;
    clearInterval(this.timer);
    this.timer = 0;
    this.send(this.target_m.toArray(), false);
  }

  // Lets go also of what this page does not hold, such as the way to the start position.
  release(): void {
    this.held = true;
    this.letGo();
  }

  private graspQuietly(view: HandView): void {
    if (!this.held) this.target_m.fromArray(view.device_m);
    this.held = true;
  }

  private place(target_m: Vector3): void {
    const { low_m, high_m } = this.hello.device;
    this.target_m.copy(target_m).clamp(new Vector3().fromArray(low_m),
                                       new Vector3().fromArray(high_m));
    this.sendNow();
  }

  // Frames of a busy browser can take 400 ms; therefore a timer repeats the message.
  private sendNow(): void {
    this.send(this.target_m.toArray(), true);
    clearInterval(this.timer);
    this.timer = window.setInterval(() => this.send(this.target_m.toArray(), true), kRepeat_ms);
  }
}
