// The cameras of the view: from above with A1 up for two sensors, an orbit for three.

import { OrthographicCamera, PerspectiveCamera, Vector3, type Camera } from "three";

const kFieldOfView_deg = 35;
const kLongestTilt_rad = 1.5; // the orbit never looks along A3, where "up" has no direction
const kClosest = 0.02; // of the radius of what is fitted
const kFarthest = 40;
const kReach = 10; // of the top view above and below its centre, as a factor of the same radius
const kRadians = Math.PI / 180;

// A sphere that the view should show.
export interface Fitted {
  centre_m: Vector3;
  radius_m: number;
}

export class ViewCamera {
  readonly camera: OrthographicCamera | PerspectiveCamera;
  private readonly centre_m = new Vector3();
  private radius_m = 0.1;
  private zoom = 1;
  private yaw_rad = 24 * kRadians;
  private tilt_rad = 36 * kRadians;
  private width_px = 1;
  private height_px = 1;

  constructor(readonly isTopView: boolean) {
    this.camera = isTopView ? new OrthographicCamera() : new PerspectiveCamera(kFieldOfView_deg);
    this.camera.up.set(isTopView ? 1 : 0, 0, isTopView ? 0 : 1);
  }

  resize(width_px: number, height_px: number): void {
    this.width_px = Math.max(1, width_px);
    this.height_px = Math.max(1, height_px);
    this.place();
  }

  // Shows the whole sphere.
  fit(fitted: Fitted): void {
    this.centre_m.copy(fitted.centre_m);
    this.radius_m = fitted.radius_m;
    this.zoom = 1;
    this.place();
  }

  // Top view: shows this length with each pixel, with the centre in the middle, and all that is less than
  // reach_m above or below the centre.
  showAtScale(centre_m: Vector3, metresPerPixel: number, reach_m: number): void {
    this.centre_m.copy(centre_m);
    this.radius_m = reach_m / kReach;
    this.zoom = (0.5 * metresPerPixel * Math.min(this.width_px, this.height_px)) / this.radius_m;
    this.place();
  }

  // factor > 1: nearer.
  zoomBy(factor: number): void {
    this.zoom = Math.min(kFarthest, Math.max(kClosest, this.zoom / factor));
    this.place();
  }

  turnBy(right_px: number, up_px: number): void {
    if (this.isTopView) return;
    const turn = Math.PI / Math.max(this.height_px, 1);
    this.yaw_rad += right_px * turn;
    this.tilt_rad = Math.min(kLongestTilt_rad,
                             Math.max(-kLongestTilt_rad, this.tilt_rad - up_px * turn));
    this.place();
  }

  // Length that one pixel shows at a point of the display frame, in metres.
  metresPerPixel(point_m: Vector3): number {
    if (this.camera instanceof OrthographicCamera) {
      return (this.camera.top - this.camera.bottom) / this.height_px;
    }
    const ahead = new Vector3().subVectors(point_m, this.camera.position).dot(this.ahead);
    return (2 * ahead * Math.tan(0.5 * kFieldOfView_deg * kRadians)) / this.height_px;
  }

  // From the camera to the middle of what is shown.
  get distance_m(): number {
    return this.camera.position.distanceTo(this.centre_m);
  }

  // Unit vectors of the view, in the display frame.
  get ahead(): Vector3 {
    return this.camera.getWorldDirection(new Vector3());
  }
  get right(): Vector3 {
    return new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
  }
  get upward(): Vector3 {
    return new Vector3().setFromMatrixColumn(this.camera.matrixWorld, 1);
  }

  // Where a point of the display frame is seen, in pixels from the upper left corner.
  pixelOf(point_m: Vector3): { x: number; y: number } {
    const seen = point_m.clone().project(this.camera as Camera);
    return { x: 0.5 * (seen.x + 1) * this.width_px, y: 0.5 * (1 - seen.y) * this.height_px };
  }

  private place(): void {
    const aspect = this.width_px / this.height_px;
    const shown_m = (this.radius_m * this.zoom) / Math.min(1, aspect); // half the height
    if (this.camera instanceof OrthographicCamera) this.placeAbove(shown_m, aspect);
    else this.placeOnOrbit(this.camera, shown_m, aspect);
    this.camera.updateProjectionMatrix();
    this.camera.updateMatrixWorld();
  }

  private placeAbove(shown_m: number, aspect: number): void {
    const camera = this.camera as OrthographicCamera;
    camera.top = shown_m;
    camera.bottom = -shown_m;
    camera.right = shown_m * aspect;
    camera.left = -camera.right;
    camera.near = 0;
    camera.far = 2 * kReach * this.radius_m;
    camera.position.copy(this.centre_m).add(new Vector3(0, 0, kReach * this.radius_m));
    camera.lookAt(this.centre_m);
  }

  private placeOnOrbit(camera: PerspectiveCamera, shown_m: number, aspect: number): void {
    const distance_m = shown_m / Math.sin(0.5 * kFieldOfView_deg * kRadians);
    const level = Math.cos(this.tilt_rad);
    const from = new Vector3(-level * Math.cos(this.yaw_rad), -level * Math.sin(this.yaw_rad),
                             Math.sin(this.tilt_rad));
    camera.aspect = aspect;
    camera.near = Math.max(0.01 * distance_m, distance_m - 6 * this.radius_m);
    camera.far = distance_m + 12 * this.radius_m;
    camera.position.copy(this.centre_m).addScaledVector(from, distance_m);
    camera.lookAt(this.centre_m);
  }
}
