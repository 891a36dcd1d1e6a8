// The JSON messages between the server of `experiment live` and the pages of the participant and of the
// experimenter. The binary messages are those of protocol.ts.

import type { Answer, Vector3 } from "./protocol.ts";

export type StepName =
  | "information" | "consent" | "check" | "instructions" | "about" | "learning" | "practice" | "block"
  | "questionnaire" | "break" | "paused" | "debriefing" | "done" | "stopped" | "refused";

// The steps after which nothing comes.
export const kEnds: readonly StepName[] = ["done", "stopped", "refused"];

export interface Step {
  step: StepName;
  title?: string; // absent: the page's own
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

// Answers to the questionnaire: tlx items 0 to 100 in steps of 5, real 1 to 7.
export type Ratings = Record<
  "tlx_mental" | "tlx_physical" | "tlx_temporal" | "tlx_performance" | "tlx_effort" | "tlx_frustration" | "real",
  number>;

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
  role: "participant";
  version: number;
  engine: string;
  language: string;
  direction: "ltr" | "rtl";
  words: Record<string, string>;
  display: { Hz: number; scale: number; sphere_radius_m: number; proxy_radius_m?: number };
  clutch?: boolean; // the plan permits it; absent: it does not
  checked?: Checked | null; // of this participant, before a reload
  inputs: Input[];
  rate_Hz: number;
  step: Step;
}

export interface Trial {
  type: "trial";
  number: number; // of all that were announced: tells trials apart
  place?: number; // in the block, as a person counts
  of: number; // trials of the block
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
  | { type: "rated"; answers: Ratings }
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

export type AttemptStatus = "done" | "timeout" | "fault" | "aborted" | "skipped";

export interface ExperimenterStatus {
  type: "status";
  participant: number;
  step: StepName;
  paused: boolean;
  trip: string | null; // why the force was cut; null: it was not, or somebody has rearmed
  block: number; // 0: practice
  blocks: number;
  trials_left: number;
  place?: number; // of the trial in its block, or of the condition to touch; absent in other steps
  places?: number;
  attempt?: number; // absent in learning
  runs?: boolean;
  condition?: string; // this and the following two: absent if the plan is blind
  object?: string;
  rules?: string[]; // of the governor that acted since the last status
  attempts: Partial<Record<AttemptStatus, number>>;
  last: { block: number; place: number; attempt: number; status: AttemptStatus; reason: string } | null;
  newest_late_us: number; // how late ticks of the trial began
  worst_late_us: number;
  missed_deadlines: number;
  pictures_Hz: number | null; // at the participant's page
}

export interface ExperimenterHello {
  type: "hello";
  role: "experimenter";
  version: number;
  engine: string;
  plan: string;
  participant: number;
  pilot: boolean;
  blind: boolean; // the server sends neither pictures nor forces nor conditions
  has_force: boolean;
  display: LiveHello["display"];
  rate_Hz: number;
  trial: Trial | null; // the newest one
  status: ExperimenterStatus;
}

// Trials and rings as the participant's page gets them, unless the plan is blind.
export type ExperimenterMessage =
  | ExperimenterStatus
  | Trial
  | { type: "ring"; p_scene_m: Vector3 | null }
  | { type: "trial_end"; number: number };

export type ExperimenterRequest =
  | { type: "note"; text: string }
  | { type: "pause" | "go_on" | "repeat" | "rearm" }
  | { type: "skip" | "abort"; block: number; place: number; attempt: number }; // the trial that is meant

export type ExperimenterAsk = (request: ExperimenterRequest) => Promise<Answer>;
