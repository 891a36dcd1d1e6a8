// The messages between the page and the server, version 4. All numbers are little-endian.

import { decodeRecord, recordBytes, type TickRecord } from "./record.ts";

export const kVersion = 4;
const kKindState = 1;
const kKindTicks = 2;
const kKindPointer = 16;
const kStateHeaderBytes = 136;
const kMostAxes = 3;
const kBodyBytes = 64;
const kTicksHeaderBytes = 24;
const kPointerBytes = 40;

export type Vector3 = [number, number, number];

// The pose of a moving body: T_scene_body.
export interface BodyPose {
  body: number;
  rotation_wxyz: [number, number, number, number];
  position_m: Vector3;
}

export interface State {
  hasTarget: boolean;
  isPaused: boolean;
  isHeld: boolean;
  pointerSequence: number; // the newest pointer message that this tick used; 0: none
  target_m: Vector3; // of the hand, device frame
  sent_s: number; // on the server's clock
  axes: Vector3[]; // a basis of the actuated span, device frame
  record: TickRecord;
  bodies: BodyPose[];
  bodyName: string; // of what is touched; "": nothing
  materialName: string; // "": nothing, or it has no material
}

// The ticks since the last message, one column per quantity.
export interface Ticks {
  lost: number; // ticks that were overwritten before the server read them
  base_s: number;
  time_s: Float32Array; // since base_s
  angle_deg: Float32Array; // NaN: no contact
  depth_m: Float32Array;
  force_N: Float32Array; // commanded
  fullForce_N: Float32Array;
  step_us: Float32Array;
  contact: Float32Array;
}

export type SettingValue = boolean | number | string | number[][];

export interface Setting {
  name: string;
  label: string;
  kind: "flag" | "number" | "choice" | "axes";
  value: SettingValue;
  low?: number;
  high?: number;
  unit?: string;
  choices?: string[];
  key?: string;
}

export interface Hello {
  type: "hello";
  version: number;
  engine: string;
  scene: {
    name: string;
    triangles: number;
    shown_triangles: number;
    simplified: boolean;
    low_m: Vector3;
    high_m: Vector3;
    extent_m: Vector3;
  };
  device: {
    name: string;
    sensors: number;
    workspace_m: number;
    low_m: Vector3;
    high_m: Vector3;
    is_simulated: boolean;
    moves_motors: boolean;
  };
  units: Record<"length" | "force" | "angle" | "time", string>;
  options: { actuators: number; scale: number; max_force_N: number | null };
  materials: string[];
  rate_Hz: number;
  plane_height_m: number | null;
  proxy_radius_m: number;
  control: boolean;
  settings: Setting[];
  start_device_m: Vector3;
  display: { name: "full" } | PaperHello;
}

// The page shows nothing but the display of the paper (paper_display.ts).
export interface PaperHello {
  name: "paper";
  Hz: number; // mean rate of the pictures
  scale: number; // length on the screen / length in the device frame
  spheres: { green_m: Vector3; red_m: Vector3; radius_m: number } | null; // centres, scene frame
}

export interface Status {
  type: "status";
  // null: no tick was measured yet
  rate_Hz: number | null;
  missed: number;
  late_p999_us: number | null;
  step_p50_us: number | null;
  step_max_us: number | null;
  trips: number;
  trip: string | null;
  faults: Record<string, number>; // since the last status
  clients: number;
  paused: boolean;
  inside: string | null; // the node inside which the hand began: no force until it has left or stays
  control: boolean;
  pending: boolean; // a setting does not act yet
  settings: Record<string, SettingValue>;
}

export interface Answer {
  type: "answer";
  id: number;
  ok: boolean;
  problem?: string;
}

export interface ServerEvent {
  type: "event";
  kind: string;
  text: string;
}

// A request of the page; the connection adds the id.
export type Request =
  | { type: "set"; name: string; value: SettingValue }
  | { type: "take_control" }
  | { type: "rearm" }
  | { type: "pause"; value: boolean }
  | { type: "start" }
  | { type: "stay" };

function vector(view: DataView, offset: number): Vector3 {
  return [
    view.getFloat64(offset, true),
    view.getFloat64(offset + 8, true),
    view.getFloat64(offset + 16, true),
  ];
}

// A name of a file may hold bytes that are not UTF-8.
function text(view: DataView, offset: number, size: number): string {
  return new TextDecoder().decode(new Uint8Array(view.buffer, view.byteOffset + offset, size));
}

function body(view: DataView, offset: number): BodyPose {
  return {
    body: view.getUint32(offset, true),
    rotation_wxyz: [
      view.getFloat64(offset + 8, true),
      view.getFloat64(offset + 16, true),
      view.getFloat64(offset + 24, true),
      view.getFloat64(offset + 32, true),
    ],
    position_m: vector(view, offset + 40),
  };
}

function decodeState(view: DataView): State {
  const flags = view.getUint32(4, true);
  const size = view.getUint32(48, true);
  const bodyCount = view.getUint32(52, true);
  const axisCount = Math.min(view.getUint32(56, true), kMostAxes);
  const nameBytes = [view.getUint16(60, true), view.getUint16(62, true)] as const;
  const namesAt = kStateHeaderBytes + size + bodyCount * kBodyBytes;
  const expected = namesAt + nameBytes[0] + nameBytes[1];
  if (size !== recordBytes || view.byteLength !== expected) {
    throw new Error(`state: has ${view.byteLength} bytes, a record of ${size}; ` +
                    `expected a record of ${recordBytes}`);
  }
  const bodies: BodyPose[] = [];
  for (let i = 0; i < bodyCount; ++i) {
    bodies.push(body(view, kStateHeaderBytes + recordBytes + i * kBodyBytes));
  }
  return {
    hasTarget: (flags & 1) !== 0,
    isPaused: (flags & 2) !== 0,
    isHeld: (flags & 4) !== 0,
    pointerSequence: Number(view.getBigUint64(8, true)),
    target_m: vector(view, 16),
    sent_s: view.getFloat64(40, true),
    axes: Array.from({ length: axisCount }, (_, n) => vector(view, 64 + 24 * n)),
    record: decodeRecord(view, kStateHeaderBytes),
    bodies,
    bodyName: text(view, namesAt, nameBytes[0]),
    materialName: text(view, namesAt + nameBytes[0], nameBytes[1]),
  };
}

function decodeTicks(view: DataView): Ticks {
  const rows = view.getUint32(4, true);
  if (view.byteLength !== kTicksHeaderBytes + 28 * rows) {
    throw new Error(`ticks: has ${view.byteLength} bytes; expected ${kTicksHeaderBytes + 28 * rows}`);
  }
  const column = (n: number): Float32Array => {
    const values = new Float32Array(rows);
    const begin = kTicksHeaderBytes + 4 * rows * n;
    for (let i = 0; i < rows; ++i) values[i] = view.getFloat32(begin + 4 * i, true);
    return values;
  };
  return {
    lost: view.getUint32(16, true),
    base_s: view.getFloat64(8, true),
    time_s: column(0),
    angle_deg: column(1),
    depth_m: column(2),
    force_N: column(3),
    fullForce_N: column(4),
    step_us: column(5),
    contact: column(6),
  };
}

export type BinaryMessage = { kind: "state"; state: State } | { kind: "ticks"; ticks: Ticks };

// Decodes a binary message of the server. Throws an Error that names what is wrong with it.
export function decodeBinary(buffer: ArrayBuffer): BinaryMessage {
  const view = new DataView(buffer);
  if (view.byteLength < kTicksHeaderBytes) {
    throw new Error(`a binary message has ${view.byteLength} bytes; expected a header`);
  }
  const kind = view.getUint16(0, true);
  const version = view.getUint16(2, true);
  if (version !== kVersion) throw new Error(`version is ${version}; expected ${kVersion}`);
  if (kind === kKindState) return { kind: "state", state: decodeState(view) };
  if (kind === kKindTicks) return { kind: "ticks", ticks: decodeTicks(view) };
  throw new Error(`kind is ${kind}; expected ${kKindState} or ${kKindTicks}`);
}

// Encodes the target of the hand. isHeld false: the hand lets go. isClutched: the hand is set back
// (`experiment live`).
export function encodePointer(sequence: number, target_m: Vector3, isHeld: boolean, isClutched = false): ArrayBuffer {
  const buffer = new ArrayBuffer(kPointerBytes);
  const view = new DataView(buffer);
  view.setUint16(0, kKindPointer, true);
  view.setUint16(2, kVersion, true);
  view.setUint32(4, (isHeld ? 1 : 0) | (isClutched ? 2 : 0), true);
  view.setBigUint64(8, BigInt(sequence), true);
  target_m.forEach((value, axis) => view.setFloat64(16 + 8 * axis, value, true));
  return buffer;
}
