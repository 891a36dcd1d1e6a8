// The display of the paper's experiment, seen from above with A1 up, with the camera metaphor: the ball
// (the proxy) stays in the middle, and the object moves. No force, axis, chart, grid or shadow. The page
// of `view` and that of a participant draw with it.

import { Box3, Color, Group, Mesh, MeshBasicMaterial, Scene, Vector3, WebGLRenderer } from "three";

import { displayOf, touchOf, type Display } from "./display.ts";
import { readFeltGlb } from "./felt_glb.ts";
import { Ball, CubeFrame, MarkPaint, Ring } from "./marks.ts";
import { PicturePacer } from "./picture_pacer.ts";
import type { State, Vector3 as Numbers } from "./protocol.ts";
import { ViewCamera } from "./view_camera.ts";
import { drawsInSoftware, kMostPixels } from "./webgl.ts";

// The values of the pixels (sRGB). Nothing is lit, so that a colour is the same everywhere. Ball, frame
// and ring have a contrast of 3:1 or more to the background and to the object.
export const paperColours = {
  background: "#0d1117",
  object: "#ffd633", // yellow
  ball: "#d81b78", // pink
  frame: "#00863a", // green
  start: "#33d17a", // green, half transparent
  end: "#f03a2e", // red, half transparent
  ring: "#2f74e0", // blue
} as const;
const kSphereOpacity = 0.5;

// Lengths on the screen, whatever the scale: the paper does not state them.
const kBallRadius_mm = 2.5; // of a proxy that is a smaller sphere, or a point
const kFrameHalf_mm = 4;
const kFrameWidth_mm = 0.8;
const kRingRadius_mm = 6;
const kInch_mm = 25.4;
export const kUncalibrated_px_per_mm = 96 / kInch_mm; // a CSS pixel by its definition

const kMarksRoom_mm = 100; // more than any mark but a sphere reaches from its place

// In which order the marks are drawn; each covers the ones before it.
const kSphereOrder = 1;
const kRingOrder = 2;
const kFrameOrder = 3;
const kBallOrder = 4;

export interface Spheres {
  green_m: Numbers; // centres, scene frame
  red_m: Numbers;
  radius_m: number;
}

export interface PaperSettings {
  Hz: number; // mean rate of the pictures
  scale: number; // length on the screen / length in the device frame
  css_px_per_mm: number; // on the screen
  proxyRadius_m: number;
}

function paintOf(colour: string, order: number): MarkPaint {
  const paint = new MarkPaint(false).isOnTop();
  paint.order = order;
  paint.color = new Color(colour);
  return paint;
}

function spherePaint(colour: string): MarkPaint {
  const paint = paintOf(colour, kSphereOrder);
  paint.seen.opacity = kSphereOpacity;
  return paint;
}

export class PaperDisplay {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly felt = new Group(); // in the scene frame
  private readonly material = new MeshBasicMaterial({ color: paperColours.object, side: 2 });
  private readonly start = new Ball(spherePaint(paperColours.start));
  private readonly end = new Ball(spherePaint(paperColours.end));
  private readonly ring = new Ring(paintOf(paperColours.ring, kRingOrder));
  private readonly frame = new CubeFrame(paintOf(paperColours.frame, kFrameOrder));
  private readonly ball = new Ball(paintOf(paperColours.ball, kBallOrder));
  private readonly bodies = new Map<number, Mesh[]>();
  private readonly bounds = new Box3(); // of the object at rest, scene frame
  private pacer: PicturePacer;
  private state: State | null = null;
  private display: Display | null = null;
  private ringNow: Vector3 | null = null;
  private request = 0; // of the next frame; 0: the display stands still
  readonly camera = new ViewCamera(true);
  readonly mode = "camera";
  readonly isSoftware: boolean;
  spheres: Spheres | null = null; // null: none are shown
  pictures = 0; // drawn so far
  drawn: State | null = null; // of the newest picture
  drawnBodies = 0;

  // onDrawn receives the time of each picture (performance.now()), right after it was drawn. Throws an
  // Error if the browser has no WebGL.
  constructor(private readonly canvas: HTMLCanvasElement, private settings: PaperSettings,
              private readonly onDrawn: (time_ms: number) => void) {
    this.isSoftware = drawsInSoftware(canvas);
    this.renderer = new WebGLRenderer({ canvas, antialias: !this.isSoftware });
    this.scene.background = new Color(paperColours.background);
    this.felt.matrixAutoUpdate = false;
    this.material.depthTest = false; // all bodies have one colour
    this.scene.add(this.felt, this.start.object, this.end.object, this.ring.object, this.frame.object,
                   this.ball.object);
    this.pacer = new PicturePacer(settings.Hz);
    this.resize();
  }

  // Replaces the object by the bodies of /felt.glb.
  load(glb: ArrayBuffer): void {
    const bodies = readFeltGlb(glb);
    this.clear();
    for (const { body, geometry, T_scene_body } of bodies) {
      const mesh = new Mesh(geometry, this.material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(T_scene_body);
      mesh.frustumCulled = false;
      this.felt.add(mesh);
      this.bodies.set(body, [...(this.bodies.get(body) ?? []), mesh]);
      geometry.computeBoundingBox();
      if (geometry.boundingBox) this.bounds.union(geometry.boundingBox.clone().applyMatrix4(T_scene_body));
    }
  }

  update(state: State): void {
    this.state = state;
  }

  // Where to return to, scene frame; null: no ring.
  set ringAt(place_scene_m: Numbers | null) {
    this.ringNow = place_scene_m && new Vector3().fromArray(place_scene_m);
  }

  // The calibration of the screen, or another proxy.
  change(settings: Partial<PaperSettings>): void {
    const before = this.settings;
    this.settings = { ...before, ...settings };
    if (this.settings.Hz !== before.Hz) this.pacer = new PicturePacer(this.settings.Hz);
  }

  resize(): void {
    const { clientWidth, clientHeight } = this.canvas;
    this.renderer.setPixelRatio(this.isSoftware ? 1 : Math.min(devicePixelRatio, kMostPixels));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.resize(clientWidth, clientHeight);
  }

  // Draws from now on, whenever a picture is due.
  run(): void {
    if (this.request !== 0) return;
    const frame = (now_ms: number): void => {
      this.request = requestAnimationFrame(frame); // first: an error in a picture ends only that picture
      if (this.pacer.isDue(now_ms) && this.draw()) this.onDrawn(performance.now());
    };
    this.request = requestAnimationFrame(frame);
  }

  stop(): void {
    cancelAnimationFrame(this.request);
    this.request = 0;
  }

  // The length on the screen of a length in the device frame, CSS pixels per metre.
  get pixels_per_m(): number {
    return 1000 * this.settings.css_px_per_mm * this.settings.scale;
  }

  get drawnTick(): number {
    return this.drawn?.record.tick ?? -1;
  }

  get lastDisplay(): Display | null {
    return this.display;
  }

  // The display has one scale, and is seen from above.
  zoomBy(): void {}
  turnBy(): void {}

  // Draws the newest state. Returns false if there is none, or if the browser has taken the memory of the
  // drawing: such a picture is not seen.
  private draw(): boolean {
    if (!this.state || this.renderer.getContext().isContextLost()) return false;
    const { record, bodies } = this.state;
    const display = displayOf(record, this.mode);
    this.display = display;
    const touch = touchOf(record, display, null);
    this.felt.matrix.copy(display.T_display_scene);
    for (const { body, rotation_wxyz: [w, x, y, z], position_m } of bodies) {
      for (const mesh of this.bodies.get(body) ?? []) {
        mesh.matrix.makeRotationFromQuaternion(mesh.quaternion.set(x, y, z, w));
        mesh.matrix.setPosition(...position_m);
      }
    }
    this.felt.updateMatrixWorld(true);
    this.drawMarks(touch.device_m, display);
    this.camera.showAtScale(touch.ball_m, 1 / this.pixels_per_m, this.reach_m(display, touch.device_m));
    this.renderer.render(this.scene, this.camera.camera);
    ++this.pictures;
    this.drawn = this.state;
    this.drawnBodies = this.bodies.size;
    return true;
  }

  private drawMarks(device_m: Vector3, display: Display): void {
    const mm_m = 1e-3 / this.settings.scale; // a millimetre on the screen, in the display frame
    this.ball.set(new Vector3(), Math.max(kBallRadius_mm * mm_m, this.settings.proxyRadius_m));
    this.frame.set(device_m, kFrameHalf_mm * mm_m, kFrameWidth_mm * mm_m);
    const { spheres } = this;
    this.start.object.visible = this.end.object.visible = spheres !== null;
    if (spheres) {
      const place = (centre_m: Numbers): Vector3 =>
        new Vector3().fromArray(centre_m).applyMatrix4(display.T_display_scene);
      this.start.set(place(spheres.green_m), spheres.radius_m);
      this.end.set(place(spheres.red_m), spheres.radius_m);
    }
    this.ring.object.visible = this.ringNow !== null;
    if (this.ringNow) {
      this.ring.set(this.ringNow.clone().applyMatrix4(display.T_display_scene), kRingRadius_mm * mm_m,
                    this.camera.camera.quaternion);
    }
  }

  // A distance from the ball within which everything is that is drawn: twice that of the farthest corner
  // of the object (moving bodies leave its bounds, spheres lie on them) or of the frame, and room.
  private reach_m(display: Display, device_m: Vector3): number {
    const object = this.bounds.isEmpty() ? new Box3(new Vector3(), new Vector3())
                                         : this.bounds.clone().applyMatrix4(display.T_display_scene);
    return 2 * Math.max(object.min.length(), object.max.length(), device_m.length()) +
      (1e-3 * kMarksRoom_mm) / this.settings.scale;
  }

  private clear(): void {
    for (const meshes of this.bodies.values()) meshes.forEach(({ geometry }) => geometry.dispose());
    this.bodies.clear();
    this.felt.clear();
    this.bounds.makeEmpty();
  }
}
