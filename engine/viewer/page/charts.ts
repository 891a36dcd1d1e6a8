// The charts of the last ten seconds: contact angle, and force commanded and full.

import uPlot from "uplot";

import { History, kSpan_s, type Line } from "./history.ts";
import type { Ticks } from "./protocol.ts";
import { palette, type Palette } from "./theme.ts";

const kHeight_px = 132;
const kLimit_deg = 30; // up to this contact angle, Figure 3 of the paper turns slowly
const kRedraw_ms = 100;
const kLeastForce_N = 1; // the force chart shows at least this range

export class Charts {
  private readonly history = new History();
  private colours: Palette = palette();
  private readonly angle: uPlot;
  private readonly force: uPlot;
  private drawn_ms = -Infinity;
  private isDirty = true;

  constructor(private readonly angleBox: HTMLElement, private readonly forceBox: HTMLElement) {
    const line = (color: (c: Palette) => string, width: number, dash?: number[]): uPlot.Series => ({
      stroke: () => color(this.colours), width, points: { show: false }, ...(dash ? { dash } : {}),
    });
    this.angle = this.chart(angleBox, [0, 90], [line((c) => c.normal, 1.5)],
                            (u) => this.drawLimit(u));
    this.force = this.chart(forceBox, null,
                            [line((c) => c.full, 1.5, [5, 3]), line((c) => c.force, 1.75)]);
    new ResizeObserver(() => this.resize()).observe(angleBox);
  }

  add(ticks: Ticks): void {
    this.history.add(ticks);
    this.isDirty = true;
  }

  repaint(): void {
    this.colours = palette();
    this.angle.redraw(false);
    this.force.redraw(false);
  }

  // Draws at most ten times a second.
  draw(now_ms: number): void {
    if (!this.isDirty || now_ms - this.drawn_ms < kRedraw_ms) return;
    this.isDirty = false;
    this.drawn_ms = now_ms;
    const set = (chart: uPlot, lines: readonly Line[]): void =>
      chart.setData(this.history.points(lines) as uPlot.AlignedData);
    set(this.angle, ["angle_deg"]);
    set(this.force, ["fullForce_N", "force_N"]);
  }

  // The points of the charts, for tests.
  points(lines: readonly Line[]): (number | null)[][] {
    return this.history.points(lines);
  }

  private chart(box: HTMLElement, range: [number, number] | null, series: uPlot.Series[],
                under?: (u: uPlot) => void): uPlot {
    const axis = (): uPlot.Axis => ({
      stroke: () => this.colours.quiet,
      grid: { stroke: () => this.colours.rule, width: 1 },
      ticks: { show: false },
      font: "11px system-ui, sans-serif",
    });
    const options: uPlot.Options = {
      width: Math.max(box.clientWidth, 200),
      height: kHeight_px,
      legend: { show: false },
      cursor: { show: false },
      padding: [8, 14, 0, 0],
      scales: {
        x: { time: false, range: [-kSpan_s, 0] },
        y: { range: range ?? ((_, low, high) => [Math.min(0, low ?? 0),
                                                 Math.max(kLeastForce_N, 1.1 * (high ?? 0))]) },
      },
      axes: [
        { ...axis(), size: 24, gap: 4, values: (_, ticks) => ticks.map((t) => (t === 0 ? "now" : `${t} s`)) },
        { ...axis(), size: 34, gap: 4, ...(range ? { splits: () => [0, 30, 60, 90] } : {}) },
      ],
      series: [{}, ...series],
      hooks: under ? { drawAxes: [under] } : {},
    };
    return new uPlot(options, [[], ...series.map(() => [])] as uPlot.AlignedData, box);
  }

  private drawLimit(u: uPlot): void {
    const { ctx, bbox } = u;
    const y = Math.round(u.valToPos(kLimit_deg, "y", true));
    ctx.save();
    ctx.strokeStyle = this.colours.limit;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
    ctx.beginPath();
    ctx.moveTo(bbox.left, y);
    ctx.lineTo(bbox.left + bbox.width, y);
    ctx.stroke();
    ctx.restore();
  }

  private resize(): void {
    for (const [chart, box] of [[this.angle, this.angleBox], [this.force, this.forceBox]] as const) {
      if (box.clientWidth > 0) chart.setSize({ width: box.clientWidth, height: kHeight_px });
    }
  }
}
