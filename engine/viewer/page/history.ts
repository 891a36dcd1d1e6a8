// The last ten seconds of ticks, as the lowest and the highest value of each interval of 20 ms, so that
// a chart draws a thousand points at every rate and misses no peak.

import type { Ticks } from "./protocol.ts";

export const kSpan_s = 10;
export const kBucket_s = 0.02;

export type Line = "angle_deg" | "force_N" | "fullForce_N";
const kLines: readonly Line[] = ["angle_deg", "force_N", "fullForce_N"];

interface Bucket {
  index: number; // time / kBucket_s, rounded down
  low: Record<Line, number>; // NaN: no value
  high: Record<Line, number>;
}

function emptyBucket(index: number): Bucket {
  const nothing = { angle_deg: NaN, force_N: NaN, fullForce_N: NaN };
  return { index, low: { ...nothing }, high: { ...nothing } };
}

export class History {
  private buckets: Bucket[] = [];
  newest_s = -Infinity;

  clear(): void {
    this.buckets = [];
    this.newest_s = -Infinity;
  }

  // Adds ticks. Times that lie before those of earlier ticks belong to a new run: it starts again.
  add(ticks: Ticks): void {
    for (let row = 0; row < ticks.time_s.length; ++row) {
      const time_s = ticks.base_s + (ticks.time_s[row] ?? 0);
      if (time_s < this.newest_s - kBucket_s) this.clear();
      this.newest_s = Math.max(this.newest_s, time_s);
      const bucket = this.bucketAt(Math.floor(time_s / kBucket_s));
      for (const line of kLines) {
        const value = ticks[line][row] ?? NaN;
        if (Number.isNaN(value)) continue;
        bucket.low[line] = Number.isNaN(bucket.low[line]) ? value : Math.min(bucket.low[line], value);
        bucket.high[line] = Number.isNaN(bucket.high[line]) ? value : Math.max(bucket.high[line], value);
      }
    }
    const first = Math.floor((this.newest_s - kSpan_s) / kBucket_s);
    const stale = this.buckets.findIndex((bucket) => bucket.index >= first);
    if (stale > 0) this.buckets.splice(0, stale);
  }

  // Times relative to the newest tick, and for each line its values; null: a gap.
  points(lines: readonly Line[]): [number[], ...(number | null)[][]] {
    const times: number[] = [];
    const values: (number | null)[][] = lines.map(() => []);
    let last = -Infinity;
    for (const bucket of this.buckets) {
      const time_s = (bucket.index + 0.5) * kBucket_s - this.newest_s;
      if (bucket.index > last + 2 && last !== -Infinity) {
        times.push(time_s - kBucket_s);
        for (const column of values) column.push(null);
      }
      last = bucket.index;
      times.push(time_s, time_s);
      lines.forEach((line, n) => {
        const low = bucket.low[line];
        values[n]?.push(Number.isNaN(low) ? null : low,
                        Number.isNaN(low) ? null : bucket.high[line]);
      });
    }
    return [times, ...values];
  }

  private bucketAt(index: number): Bucket {
    const newest = this.buckets.at(-1);
    if (newest && newest.index >= index) return newest;
    const bucket = emptyBucket(index);
    this.buckets.push(bucket);
    return bucket;
  }
}
