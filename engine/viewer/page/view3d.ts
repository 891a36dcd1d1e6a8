// The view: felt scene and contact, drawn by WebGL when something has changed.

import { PCFShadowMap, Vector3, WebGLRenderer } from "three";

import { ContactDrawing, type DrawingSettings } from "./contact_drawing.ts";
import { displayOf, touchOf, type Display, type DisplayMode, type Touch } from "./display.ts";
import { readFeltGlb } from "./felt_glb.ts";
import { FeltScene } from "./felt_scene.ts";
import type { Hello, State } from "./protocol.ts";
import { palette } from "./theme.ts";
import { ViewCamera } from "./view_camera.ts";
import { drawsInSoftware, kMostPixels } from "./webgl.ts";

const kMargin = 1.12; // between the scene and the border, as a factor of its radius
const kCameraMargin = 1.5; // the same for the camera metaphor, where the scene is off the middle

export class View3d {
  private readonly renderer: WebGLRenderer;
  private readonly felt = new FeltScene();
  private readonly contact = new ContactDrawing();
  private view = new ViewCamera(true);
  private hello: Hello | null = null;
  private state: State | null = null;
  private display: Display | null = null;
  private touch: Touch | null = null;
  private modeNow: DisplayMode = "classical";
  private axes: readonly (readonly number[])[] = [];
  private isDirty = true;
  private needsFit = true;
  private isFlat = false;
  private bodies = 0; // that were loaded
  readonly isSoftware: boolean;
  pictures = 0; // drawn so far
  // Of the newest picture.
  drawnTick = -1;
  drawnBodies = 0;
  drawnMode: DisplayMode = "classical";

  // Throws an Error if the browser has no WebGL.
  constructor(private readonly canvas: HTMLCanvasElement) {
    this.isSoftware = drawsInSoftware(canvas);
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.isSoftware });
    this.renderer.setPixelRatio(this.isSoftware ? 1 : Math.min(devicePixelRatio, kMostPixels));
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.felt.scene.add(this.contact.object);
    this.contact.object.visible = false;
    // A browser may take the memory of the drawing, and later give it back.
    canvas.addEventListener("webglcontextrestored", () => {
      this.renderer.shadowMap.needsUpdate = true;
      this.isDirty = true;
    });
    this.repaint();
  }

  greet(hello: Hello): void {
    const isFirst = this.hello === null;
    this.hello = hello;
    if (isFirst) this.view = new ViewCamera(hello.device.sensors === 2);
    this.resize();
  }

  // Replaces the drawn bodies by those of /felt.glb.
  load(glb: ArrayBuffer): void {
    if (!this.hello) return;
    const bodies = readFeltGlb(glb);
    this.felt.load(bodies, this.hello);
    if (this.bodies === 0) this.needsFit = true;
    this.bodies = bodies.length;
    this.renderer.shadowMap.needsUpdate = true;
    this.isDirty = true;
  }

  update(state: State): void {
    this.state = state;
    this.isDirty = true;
  }

  set mode(mode: DisplayMode) {
    this.modeNow = mode;
    this.needsFit = true;
    this.isDirty = true;
  }
  get mode(): DisplayMode {
    return this.modeNow;
  }

  set actuatedAxes(axes: readonly (readonly number[])[]) {
    this.axes = axes;
    this.isDirty = true;
  }

  set triangles(isShown: boolean) {
    this.felt.setTriangles(isShown);
    this.isDirty = true;
  }

  // White bodies on black, and no contact: for tests that compare outlines.
  set flat(isFlat: boolean) {
    this.isFlat = isFlat;
    this.felt.setFlat(isFlat);
    this.isDirty = true;
  }

  repaint(): void {
    const colours = palette();
    this.felt.paint(colours);
    this.contact.paint(colours);
    this.isDirty = true;
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.view.resize(clientWidth, clientHeight);
    this.isDirty = true;
  }

  fit(): void {
    this.needsFit = true;
    this.isDirty = true;
  }

  zoomBy(factor: number): void {
    this.view.zoomBy(factor);
    this.isDirty = true;
  }

  turnBy(right_px: number, up_px: number): void {
    this.view.turnBy(right_px, up_px);
    this.isDirty = true;
  }

  get camera(): ViewCamera {
    return this.view;
  }
  get lastDisplay(): Display | null {
    return this.display;
  }
  get lastTouch(): Touch | null {
    return this.touch;
  }
  get gridStep_m(): number {
    return this.felt.gridStep_m;
  }

  // Draws if something has changed. Returns true if it drew.
  draw(): boolean {
    if (!this.isDirty || !this.state || !this.hello) return false;
    this.isDirty = false;
    const { record, bodies, hasTarget, target_m } = this.state;
    this.display = displayOf(record, this.modeNow);
    if (this.felt.place(this.display, bodies)) this.renderer.shadowMap.needsUpdate = true;
    this.touch = touchOf(record, this.display, hasTarget ? target_m : null);
    if (this.needsFit) this.fitNow(this.display);
    this.drawContact(this.touch);
    this.felt.setHaze(this.view.distance_m);
    this.renderer.render(this.felt.scene, this.view.camera);
    ++this.pictures;
    this.drawnTick = record.tick;
    this.drawnBodies = this.bodies;
    this.drawnMode = this.modeNow;
    return true;
  }

  // A PNG picture of the present state.
  picture(): Promise<Blob | null> {
    this.isDirty = true;
    this.draw();
    return new Promise((resolve) => this.canvas.toBlob(resolve, "image/png"));
  }

  private fitNow(display: Display): void {
    if (this.felt.radius_m === 0) return;
    this.needsFit = false;
    const isCamera = this.modeNow === "camera";
    this.view.fit({
      centre_m: isCamera ? new Vector3()
                         : this.felt.centre_scene_m.applyMatrix4(display.T_display_scene),
      radius_m: this.felt.radius_m * (isCamera ? kCameraMargin : kMargin),
    });
  }

  private drawContact(touch: Touch): void {
    this.contact.object.visible = !this.isFlat;
    if (this.isFlat || !this.hello) return;
    const settings: DrawingSettings = {
      radius_m: this.hello.proxy_radius_m,
      sceneRadius_m: this.felt.radius_m,
      axes: this.axes,
    };
    this.contact.draw(touch, {
      metresPerPixel: (point) => this.view.metresPerPixel(point),
      ahead: this.view.ahead,
      rotation: this.view.camera.quaternion,
      isTopView: this.view.isTopView,
    }, settings);
  }
}
