// The felt bodies in sun and soft shadow, on a floor with a grid in the device frame.

import {
  AmbientLight, Box3, BufferAttribute, BufferGeometry, Color, DirectionalLight, Fog, Group,
  LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshLambertMaterial,
  PlaneGeometry, Quaternion, Scene, ShadowMaterial, Vector3, WireframeGeometry,
} from "three";

import type { Display } from "./display.ts";
import type { FeltBody } from "./felt_glb.ts";
import type { BodyPose, Hello } from "./protocol.ts";
import type { Palette } from "./theme.ts";

const kShadowPixels = 1024;
const kGridCells = 10; // about, across the scene
// Towards the sun, display frame: at the upper left of the view.
const kSunOfTopView = new Vector3(0.45, 0.55, 1).normalize();
const kSunOfOrbit = new Vector3(-0.3, 0.55, 0.9).normalize();

// The step of a grid: 1, 2 or 5 times a power of ten.
export function roundStep(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length));
  const digit = length / power;
  return (digit < 2 ? 1 : digit < 5 ? 2 : 5) * power;
}

interface DrawnBody {
  index: number;
  mesh: Mesh;
  edges: LineSegments | null;
}

export class FeltScene {
  readonly scene = new Scene();
  private readonly felt = new Group(); // in the scene frame
  private readonly ground = new Group();
  private bodies: DrawnBody[] = [];
  private readonly material = new MeshLambertMaterial({ flatShading: true, side: 2, fog: false });
  private readonly flatMaterial = new MeshBasicMaterial({ color: 0xffffff, side: 2, fog: false });
  private readonly edgeMaterial = new LineBasicMaterial({ transparent: true, opacity: 0.55, fog: false });
  private readonly gridMaterial = new LineBasicMaterial();
  private readonly shadowMaterial = new ShadowMaterial();
  private readonly sun = new DirectionalLight(0xfff4e0, 2.3);
  private readonly sky = new AmbientLight(0xe8f0ff, 1.35);
  private grid: LineSegments | null = null;
  private floor: Mesh | null = null;
  private showsTriangles = false;
  private isFlat = false;
  private readonly low = new Vector3();
  private readonly high = new Vector3();
  private readonly haze = new Fog(0);
  private towardsSun = kSunOfTopView;
  private lastPose: Matrix4 | null = null;
  private colours: Palette | null = null;

  constructor() {
    this.felt.matrixAutoUpdate = false;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(kShadowPixels, kShadowPixels);
    this.sun.shadow.radius = 4;
    this.scene.add(this.felt, this.ground, this.sky, this.sun, this.sun.target);
  }

  get radius_m(): number {
    return 0.5 * this.high.distanceTo(this.low);
  }

  get centre_scene_m(): Vector3 {
    return new Vector3().addVectors(this.low, this.high).multiplyScalar(0.5);
  }

  // Replaces the bodies.
  load(bodies: readonly FeltBody[], hello: Hello): void {
    for (const { mesh, edges } of this.bodies) {
      mesh.geometry.dispose();
      edges?.geometry.dispose();
    }
    this.felt.clear();
    this.low.fromArray(hello.scene.low_m);
    this.high.fromArray(hello.scene.high_m);
    this.bodies = bodies.map(({ body, geometry, T_scene_body }) => {
      const mesh = new Mesh(geometry, this.material);
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(T_scene_body);
      mesh.castShadow = mesh.receiveShadow = true;
      this.felt.add(mesh);
      return { index: body, mesh, edges: null };
    });
    const isTopView = hello.device.sensors === 2;
    this.scene.fog = isTopView ? null : this.haze;
    this.towardsSun = isTopView ? kSunOfTopView : kSunOfOrbit;
    this.makeGround();
    this.placeSun();
    this.lastPose = null;
    this.setFlat(this.isFlat);
    this.setTriangles(this.showsTriangles);
  }

  paint(colours: Palette): void {
    this.colours = colours;
    this.material.color.set(colours.felt);
    this.edgeMaterial.color.set(colours.edge);
    this.gridMaterial.color.set(colours.grid);
    this.shadowMaterial.opacity = colours.shadow;
    this.scene.background = this.isFlat ? new Color(0) : new Color(colours.background);
    this.haze.color.set(colours.background);
  }

  setTriangles(isShown: boolean): void {
    this.showsTriangles = isShown;
    for (const body of this.bodies) {
      if (isShown && !body.edges) {
        body.edges = new LineSegments(new WireframeGeometry(body.mesh.geometry), this.edgeMaterial);
        body.mesh.add(body.edges);
      }
      if (body.edges) body.edges.visible = isShown && !this.isFlat;
    }
  }

  // White bodies on black, without light, floor and edges: for tests that compare outlines.
  setFlat(isFlat: boolean): void {
    this.isFlat = isFlat;
    for (const { mesh } of this.bodies) mesh.material = isFlat ? this.flatMaterial : this.material;
    this.ground.visible = !isFlat;
    this.sun.castShadow = !isFlat;
    if (this.colours) this.paint(this.colours);
    this.setTriangles(this.showsTriangles);
  }

  // Places the bodies. Returns true if a shadow has changed.
  place(display: Display, poses: readonly BodyPose[]): boolean {
    const moved = !this.lastPose?.equals(display.T_display_scene) || poses.length > 0;
    this.lastPose = display.T_display_scene.clone();
    this.felt.matrix.copy(display.T_display_scene);
    for (const pose of poses) this.placeBody(pose);
    this.felt.updateMatrixWorld(true);
    const centre = this.centre_scene_m.applyMatrix4(display.T_display_scene);
    this.ground.position.copy(display.T_display_device);
    this.ground.position.z = this.lowest_m(display);
    if (moved) {
      this.sun.target.position.copy(centre);
      this.sun.position.copy(centre).addScaledVector(this.towardsSun, 3 * this.radius_m);
    }
    return moved;
  }

  // The floor fades beyond this distance from the camera, before its lines are finer than pixels.
  setHaze(distance_m: number): void {
    this.haze.near = distance_m;
    this.haze.far = distance_m + 5 * this.radius_m;
  }

  // The height of the floor: the lowest corner of the scene's bounds.
  private lowest_m(display: Display): number {
    const bounds = new Box3(this.low.clone(), this.high.clone()); // a Box3 keeps what it gets
    return bounds.applyMatrix4(display.T_display_scene).min.z;
  }

  private placeBody(pose: BodyPose): void {
    const [w, x, y, z] = pose.rotation_wxyz;
    const rotation = new Quaternion(x, y, z, w);
    const position = new Vector3().fromArray(pose.position_m);
    for (const { index, mesh } of this.bodies) {
      if (index === pose.body) mesh.matrix.compose(position, rotation, new Vector3(1, 1, 1));
    }
  }

  private placeSun(): void {
    const shadow = this.sun.shadow.camera;
    const reach_m = 1.6 * this.radius_m;
    shadow.left = shadow.bottom = -reach_m;
    shadow.right = shadow.top = reach_m;
    shadow.near = 0.1 * this.radius_m;
    shadow.far = 7 * this.radius_m;
    shadow.updateProjectionMatrix();
    // The soft edge is 4 texels of 3.2 radii / 1024 wide; across it a face that the sun meets at 55
    // degrees falls by 0.7 of that, which is 0.0013 of the depth of the shadow; twice that is enough.
    this.sun.shadow.bias = -0.0026;
  }

  private makeGround(): void {
    this.ground.clear();
    this.grid?.geometry.dispose();
    this.floor?.geometry.dispose();
    const step_m = this.gridStep_m;
    const half = Math.ceil((8 * this.radius_m) / step_m);
    const points: number[] = [];
    for (let i = -half; i <= half; ++i) {
      points.push(i * step_m, -half * step_m, 0, i * step_m, half * step_m, 0);
      points.push(-half * step_m, i * step_m, 0, half * step_m, i * step_m, 0);
    }
    const lines = new BufferGeometry();
    lines.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    this.grid = new LineSegments(lines, this.gridMaterial);
    this.floor = new Mesh(new PlaneGeometry(2 * half * step_m, 2 * half * step_m),
                          this.shadowMaterial);
    this.floor.receiveShadow = true;
    this.floor.position.z = 0.002 * this.radius_m; // so that the shadow covers the lines
    this.ground.add(this.grid, this.floor);
  }

  get gridStep_m(): number {
    return roundStep((2 * this.radius_m) / kGridCells);
  }
}
