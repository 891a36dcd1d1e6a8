// Draws what the tool does in one tick: ball, device point, line between, normal, forces, rails of
// the motors and the target of the hand.

import { Color, Group, type Quaternion, Vector3 } from "three";

import type { Touch } from "./display.ts";
import { Arrow, Ball, CubeFrame, DashedRod, MarkPaint, Plate, Ring, Rod } from "./marks.ts";
import type { Palette } from "./theme.ts";

const kLeastBall_px = 7;
const kRailGap_px = 4;
const kForceArrow = 0.06; // length of 1 N, as a share of the radius of the scene
const kLongestForce = 0.9; // longest arrow, as a share of the same radius
const kNormal_px = 40;

export interface View {
  metresPerPixel(point_m: Vector3): number;
  ahead: Vector3;
  rotation: Quaternion;
  isTopView: boolean;
}

export interface DrawingSettings {
  radius_m: number; // of the ball; 0: a point
  sceneRadius_m: number;
  axes: readonly (readonly number[])[]; // actuated, unit
}

// The length of the arrow of a force. Arrows longer than kLongestForce are shortened.
export function arrowOf(force_N: Vector3, sceneRadius_m: number): Vector3 {
  const arrow = force_N.clone().multiplyScalar(kForceArrow * sceneRadius_m);
  return arrow.clampLength(0, kLongestForce * sceneRadius_m);
}

export class ContactDrawing {
  readonly object = new Group();
  private readonly paints = {
    ball: new MarkPaint(true),
    plate: new MarkPaint(false),
    frame: new MarkPaint(false),
    line: new MarkPaint(false),
    normal: new MarkPaint(false).isOnTop(), // it often lies along the force
    force: new MarkPaint(false),
    missing: new MarkPaint(false),
    rail: new MarkPaint(false),
    target: new MarkPaint(false),
  };
  private readonly ball = new Ball(this.paints.ball);
  private readonly plate = new Plate(this.paints.plate);
  private readonly frame = new CubeFrame(this.paints.frame);
  private readonly line = new Rod(this.paints.line);
  private readonly normal = new Arrow(this.paints.normal);
  private readonly force = new Arrow(this.paints.force);
  private readonly missing = new DashedRod(this.paints.missing);
  private readonly target = new Ring(this.paints.target);
  private readonly rails = Array.from({ length: 6 }, () => new Rod(this.paints.rail));
  private readonly free = new Color();
  private readonly touching = new Color();

  constructor() {
    const marks = [...this.rails, this.line, this.plate, this.ball, this.frame, this.missing,
                   this.force, this.normal, this.target];
    for (const mark of marks) this.object.add(mark.object);
  }

  paint(palette: Palette): void {
    const { paints } = this;
    this.free.set(palette.ballFree);
    this.touching.set(palette.ball);
    paints.plate.color = new Color(palette.plate);
    paints.frame.color = new Color(palette.device);
    paints.line.color = new Color(palette.line);
    paints.normal.color = new Color(palette.normal);
    paints.force.color = new Color(palette.force);
    paints.missing.color = new Color(palette.force);
    paints.rail.color = new Color(palette.rail);
    paints.target.color = new Color(palette.target);
  }

  draw(touch: Touch, view: View, settings: DrawingSettings): void {
    for (const paint of Object.values(this.paints)) paint.isAlwaysSeen = view.isTopView;
    const pixel_m = view.metresPerPixel(touch.ball_m);
    const radius_m = Math.max(settings.radius_m, kLeastBall_px * pixel_m);
    this.paints.ball.color = touch.isContact ? this.touching : this.free;
    this.ball.set(touch.ball_m, radius_m);
    this.frame.set(touch.device_m, 1.35 * radius_m, 2 * pixel_m);
    this.line.set(touch.ball_m, touch.device_m, 1.2 * pixel_m);
    this.drawContact(touch, radius_m, pixel_m);
    this.drawForces(touch, settings, pixel_m);
    this.drawRails(touch, view, settings, pixel_m);
    this.target.object.visible = touch.target_m !== null;
    if (touch.target_m) this.target.set(touch.target_m, 9 * pixel_m, view.rotation);
  }

  // In contact, a plate lies on the surface and the normal stands on it.
  private drawContact(touch: Touch, radius_m: number, pixel_m: number): void {
    const { normal, isContact, ball_m } = touch;
    this.plate.object.visible = this.normal.object.visible = isContact && normal !== null;
    if (!normal || !isContact) return;
    const foot = ball_m.clone().addScaledVector(normal, -radius_m);
    this.plate.set(foot, normal, 2.4 * radius_m, 2.5 * pixel_m);
    const begin = ball_m.clone().addScaledVector(normal, radius_m);
    const end = begin.clone().addScaledVector(normal, kNormal_px * pixel_m);
    this.normal.set(begin, end, 1.2 * pixel_m);
  }

  // The commanded force begins at the ball; what the device cannot give continues at its tip, so that
  // both together are the full force.
  private drawForces(touch: Touch, settings: DrawingSettings, pixel_m: number): void {
    const full = arrowOf(touch.fullForce_N, settings.sceneRadius_m);
    const share = touch.fullForce_N.length() > 0
      ? full.length() / touch.fullForce_N.length() : 0;
    const given = touch.force_N.clone().multiplyScalar(share);
    const tip = touch.ball_m.clone().add(given);
    this.force.set(touch.ball_m, tip, 2.2 * pixel_m);
    this.missing.set(tip, touch.ball_m.clone().add(full), 1.6 * pixel_m, 6 * pixel_m);
  }

  // Two parallel lines along each actuated axis, through the device point.
  private drawRails(touch: Touch, view: View, settings: DrawingSettings, pixel_m: number): void {
    this.rails.forEach((rail, index) => {
      const axis = settings.axes[index >> 1];
      rail.object.visible = axis !== undefined;
      if (!axis) return;
      const along = new Vector3().fromArray(axis as number[]);
      const aside = new Vector3().crossVectors(along, view.ahead);
      if (aside.length() < 1e-3) aside.set(along.y, along.z, along.x); // seen along the axis
      aside.setLength((index % 2 === 0 ? 1 : -1) * kRailGap_px * pixel_m);
      const middle = touch.device_m.clone().add(aside);
      const reach_m = 4 * settings.sceneRadius_m;
      rail.set(middle.clone().addScaledVector(along, -reach_m),
               middle.clone().addScaledVector(along, reach_m), 0.5 * pixel_m);
    });
  }
}
