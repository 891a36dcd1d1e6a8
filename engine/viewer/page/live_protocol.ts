// The JSON messages between the server of `experiment live` and the participant's page. The binary
// messages are those of protocol.ts.

import type { Answer, Vector3 } from "./protocol.ts";

export type StepName =
  | "information" | "consent" | "check" | "instructions" | "about" | "learning" | "practice" | "block"
  | "break" | "paused" | "debriefing" | "done" | "stopped" | "refused";

export interface Step {
  step: StepName;
  title: string;
  text: string; // plain; blank lines separate paragraphs
  number: number; // of the block; 0: practice
  of: number; // blocks
  remaining_s: number | null; // of a break
  may_go_on: boolean;
  about: AboutKey[];
}

export type Input = "mouse" | "pen" | "touch" | "board";
export type Motion = "unaccelerated" | "accelerated" | "unknown";
export type AboutKey = "age" | "gender" | "hand" | "experience";

// What the input check has found.
export interface Checked {
  input: Input;
  motion: Motion;
  css_px_per_mm: number;
  device_pixel_ratio: number;
  width_px: number; // of the screen, CSS pixels
  height_px: number;
  refresh_Hz: number;
  unadjusted: boolean | null; // whether the browser granted it; null: no pointer lock for this input
  stroke_ratio: number | null; // length of fast strokes / of slow ones; null: not measured
}

export interface LiveHello {
  type: "hello";
  version: number;
  engine: string;
  language: string;
  direction: "ltr" | "rtl";
  words: Record<string, string>;
  display: { Hz: number; scale: number; sphere_radius_m: number; proxy_radius_m?: number };
  checked?: Checked | null; // of this participant, before a reload
  inputs: Input[];
  rate_Hz: number;
  is_script: boolean; // a script takes part, and this page only shows it
  step: Step;
}

export interface Trial {
  type: "trial";
  number: number;
  of: number;
  scene: number;
  green_m: Vector3; // centres of the spheres, scene frame
  red_m: Vector3;
  radius_m: number;
  start_device_m: Vector3; // where the device point is at first, device frame
  step: "learning" | "practice" | "block";
}

export type LiveMessage =
  | ({ type: "step" } & Step)
  | Trial
  | { type: "ring"; p_scene_m: Vector3 | null }
  | { type: "trial_end"; number: number }
  | { type: "status"; paused: boolean; remaining_s?: number | null };

// Why a running trial ends. The server aborts it.
export type LeftWhy = "focus" | "full_screen" | "pointer_lock" | "hidden";

// A request; the connection adds the id.
export type LiveRequest =
  | { type: "next"; step: StepName }
  | { type: "consent"; value: boolean }
  | { type: "about"; answers: Partial<Record<AboutKey, string>> }
  | ({ type: "checked" } & Checked)
  | { type: "ready"; trial: number }
  | { type: "pause" }
  | { type: "go_on" }
  | { type: "stop"; keep: boolean };

// What has no answer.
export type LiveNotice =
  | { type: "left"; why: LeftWhy }
  | { type: "frames"; times_ms: number[] };

export type Ask = (request: LiveRequest) => Promise<Answer>;
