// The frame that the page shows, as display_transform() of the engine (haptics/a4/scene_pose.h)
// defines it. The axes of the display are parallel to the device's.

import { Matrix4, Quaternion, Vector3 } from "three";

import type { TickRecord } from "./record.ts";

export type DisplayMode = "classical" | "camera";

export interface Display {
  T_display_scene: Matrix4;
  T_display_device: Vector3; // a translation
}

function vector(values: readonly number[]): Vector3 {
  return new Vector3(values[0], values[1], values[2]);
}

// Classical: the device frame, in which the proxy moves. Camera metaphor: the proxy stays at the
// origin, and the scene moves instead.
export function displayOf(record: TickRecord, mode: DisplayMode): Display {
  const [w, x, y, z] = record.q_after_wxyz;
  const rotation = new Quaternion(x, y, z, w);
  const origin = vector(record.o_after_m);
  const proxy = vector(record.proxy_scene_m).applyQuaternion(rotation);
  const translation = mode === "camera" ? proxy.clone().negate() : origin.clone();
  return {
    T_display_scene: new Matrix4().compose(translation, rotation, new Vector3(1, 1, 1)),
    T_display_device: translation.clone().sub(origin),
  };
}

// What a record shows besides the scene, in the display frame.
export interface Touch {
  ball_m: Vector3; // the proxy
  device_m: Vector3;
  target_m: Vector3 | null;
  normal: Vector3 | null; // unit; null: no contact, or normals cancel
  force_N: Vector3; // commanded
  fullForce_N: Vector3;
  isContact: boolean;
}

export function touchOf(record: TickRecord, display: Display,
                        target_device_m: readonly number[] | null): Touch {
  const normal = vector(record.normal_scene).transformDirection(display.T_display_scene);
  const shift = display.T_display_device;
  return {
    ball_m: vector(record.proxy_scene_m).applyMatrix4(display.T_display_scene),
    device_m: vector(record.device_m).add(shift),
    target_m: target_device_m ? vector(target_device_m).add(shift) : null,
    normal: vector(record.normal_scene).length() > 0.5 ? normal : null,
    force_N: vector(record.force_device_N),
    fullForce_N: vector(record.full_force_device_N),
    isContact: record.contact !== 0,
  };
}
