// Whether a mouse moves farther when it is fast: strokes of one length on the table, slow and fast.

import type { Motion } from "./live_protocol.ts";

const kLeastSlow_s = 2; // over the 86 mm of a card: less than 43 mm/s
const kMostFast_s = 0.5; // more than 171 mm/s
const kShortest_px = 40; // a stroke of a mouse with the coarsest resolution in use is longer
// Ends of strokes are off by some mm. Adaptive acceleration changes the length by more than this.
const kMostEven = 1.25;

export const kStrokes = ["slow", "fast", "slow", "fast"] as const;
export type StrokeSpeed = (typeof kStrokes)[number];
export type StrokeFault = "too_fast" | "too_slow" | "too_short";

// What is wrong with a stroke, or null.
export function faultOf(speed: StrokeSpeed, length_px: number, time_s: number): StrokeFault | null {
  if (length_px < kShortest_px) return "too_short";
  if (speed === "slow" && time_s < kLeastSlow_s) return "too_fast";
  if (speed === "fast" && time_s > kMostFast_s) return "too_slow";
  return null;
}

// The length of fast strokes over that of slow ones. lengths_px: one for each of kStrokes.
export function strokeRatio(lengths_px: readonly number[]): number {
  const sum = (speed: StrokeSpeed): number =>
    kStrokes.reduce((total, kind, i) => (kind === speed ? total + (lengths_px[i] ?? 0) : total), 0);
  return sum("fast") / sum("slow");
}

export function isEven(ratio: number): boolean {
  return ratio < kMostEven && ratio > 1 / kMostEven;
}

// What is known of a mouse. ratio: null if no strokes were made.
export function motionOf(ratio: number | null, isUnadjusted: boolean): Motion {
  if (ratio !== null) return isEven(ratio) ? "unaccelerated" : "accelerated";
  return isUnadjusted ? "unaccelerated" : "unknown";
}
