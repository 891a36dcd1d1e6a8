// Solids of constant width in pixels that the contact is drawn with. A part of a mark that the scene
// hides is drawn too, faintly (orbit) or fully (top view).

import {
  BoxGeometry, ConeGeometry, CylinderGeometry, GreaterDepth, Group, InstancedMesh, Matrix4,
  Mesh, MeshBasicMaterial, MeshLambertMaterial, Quaternion, SphereGeometry, TorusGeometry, Vector3,
  type BufferGeometry, type Color, type Material,
} from "three";

const kHiddenOpacity = 0.3;
const kGlow = 0.35; // share of its colour that a shaded mark has without light
const kMostDashes = 64;
const kHiddenOrder = 1;
const kSeenOrder = 2;
const kTopOrder = 3;
const kUpward = new Vector3(0, 1, 0);

type MarkMaterial = MeshBasicMaterial | MeshLambertMaterial;

// Two materials of one colour: for the part that is seen, and for the part that the scene hides.
export class MarkPaint {
  readonly seen: MarkMaterial;
  readonly hidden: MarkMaterial;
  order = kSeenOrder; // in which three.js draws

  constructor(isShaded: boolean, hasHiddenPart = true) {
    const make = (): MarkMaterial =>
      isShaded ? new MeshLambertMaterial({ transparent: true, fog: false })
               : new MeshBasicMaterial({ transparent: true, fog: false });
    this.seen = make();
    this.hidden = make();
    this.hidden.depthFunc = GreaterDepth;
    this.hidden.depthWrite = false;
    this.hidden.visible = hasHiddenPart;
    this.hidden.opacity = kHiddenOpacity;
  }

  set color(color: Color) {
    for (const material of [this.seen, this.hidden]) {
      material.color.copy(color);
      if (material instanceof MeshLambertMaterial) material.emissive.copy(color).multiplyScalar(kGlow);
    }
  }

  // Drawn last, over all that it touches.
  isOnTop(): this {
    this.seen.depthTest = false;
    this.order = kTopOrder;
    this.hidden.visible = false;
    return this;
  }

  set isAlwaysSeen(value: boolean) {
    this.hidden.opacity = value ? 1 : kHiddenOpacity;
  }
}

// A mesh and its hidden part.
function twoParts(geometry: BufferGeometry, paint: MarkPaint): Group {
  const group = new Group();
  const add = (material: Material, order: number): void => {
    const mesh = new Mesh(geometry, material);
    mesh.renderOrder = order;
    group.add(mesh);
  };
  add(paint.hidden, kHiddenOrder);
  add(paint.seen, paint.order);
  return group;
}

const kRod = new CylinderGeometry(1, 1, 1, 12);
const kTip = new ConeGeometry(1, 1, 20);
const kBall = new SphereGeometry(1, 40, 24);
const kPlate = new CylinderGeometry(1, 1, 1, 40);
const kRing = new TorusGeometry(1, 0.16, 10, 40);
const kEdge = new BoxGeometry(1, 1, 1);

// A straight line from a to b.
export class Rod {
  readonly object: Group;

  constructor(paint: MarkPaint) {
    this.object = twoParts(kRod, paint);
  }

  set(a: Vector3, b: Vector3, radius_m: number): void {
    const along = new Vector3().subVectors(b, a);
    const length_m = along.length();
    this.object.visible = length_m > 0;
    if (length_m === 0) return;
    this.object.position.addVectors(a, b).multiplyScalar(0.5);
    this.object.quaternion.setFromUnitVectors(kUpward, along.divideScalar(length_m));
    this.object.scale.set(radius_m, length_m, radius_m);
  }
}

// An arrow from a to b. A short arrow consists of its tip only.
export class Arrow {
  readonly object = new Group();
  private readonly rod: Rod;
  private readonly tip: Group;

  constructor(paint: MarkPaint) {
    this.rod = new Rod(paint);
    this.tip = twoParts(kTip, paint);
    this.object.add(this.rod.object, this.tip);
  }

  set(a: Vector3, b: Vector3, radius_m: number): void {
    const along = new Vector3().subVectors(b, a);
    const length_m = along.length();
    this.object.visible = length_m > radius_m;
    if (!this.object.visible) return;
    along.divideScalar(length_m);
    const tip_m = Math.min(length_m, 7 * radius_m);
    const neck = b.clone().addScaledVector(along, -tip_m);
    this.rod.set(a, neck, radius_m);
    this.tip.position.copy(b).addScaledVector(along, -0.5 * tip_m);
    this.tip.quaternion.setFromUnitVectors(kUpward, along);
    this.tip.scale.set(0.4 * tip_m, tip_m, 0.4 * tip_m);
  }
}

// A dashed line from a to b, which begins and ends with a dash.
export class DashedRod {
  readonly object = new Group();
  private readonly parts: InstancedMesh[];

  constructor(paint: MarkPaint) {
    this.parts = [paint.hidden, paint.seen].map((material) => {
      const mesh = new InstancedMesh(kRod, material, kMostDashes);
      mesh.renderOrder = material === paint.seen ? paint.order : kHiddenOrder;
      mesh.frustumCulled = false;
      return mesh;
    });
    this.object.add(...this.parts);
  }

  set(a: Vector3, b: Vector3, radius_m: number, dash_m: number): void {
    const along = new Vector3().subVectors(b, a);
    const length_m = along.length();
    this.object.visible = length_m > 0.5 * dash_m;
    if (!this.object.visible) return;
    along.divideScalar(length_m);
    const turned = new Quaternion().setFromUnitVectors(kUpward, along);
    const count = Math.min(kMostDashes, Math.max(1, Math.round((length_m / dash_m + 0.8) / 1.8)));
    const dashOfAll_m = length_m / (1.8 * count - 0.8); // gaps are 0.8 dashes
    for (let i = 0; i < count; ++i) {
      const begin_m = 1.8 * dashOfAll_m * i;
      const end_m = begin_m + dashOfAll_m;
      const middle = a.clone().addScaledVector(along, 0.5 * (begin_m + end_m));
      const size = new Vector3(radius_m, end_m - begin_m, radius_m);
      const placed = new Matrix4().compose(middle, turned, size);
      for (const part of this.parts) part.setMatrixAt(i, placed);
    }
    for (const part of this.parts) {
      part.count = count;
      part.instanceMatrix.needsUpdate = true;
    }
  }
}

export class Ball {
  readonly object: Group;

  constructor(paint: MarkPaint) {
    this.object = twoParts(kBall, paint);
  }

  set(centre: Vector3, radius_m: number): void {
    this.object.position.copy(centre);
    this.object.scale.setScalar(radius_m);
  }
}

// A round plate through a point, across a direction.
export class Plate {
  readonly object: Group;

  constructor(paint: MarkPaint) {
    this.object = twoParts(kPlate, paint);
  }

  set(point: Vector3, across: Vector3, radius_m: number, thickness_m: number): void {
    this.object.position.copy(point);
    this.object.quaternion.setFromUnitVectors(kUpward, across);
    this.object.scale.set(radius_m, thickness_m, radius_m);
  }
}

// A ring that faces the camera.
export class Ring {
  readonly object: Group;

  constructor(paint: MarkPaint) {
    this.object = twoParts(kRing, paint);
  }

  set(centre: Vector3, radius_m: number, towards: Quaternion): void {
    this.object.position.copy(centre);
    this.object.quaternion.copy(towards);
    this.object.scale.setScalar(radius_m);
  }
}

// The twelve edges of a cube.
export class CubeFrame {
  readonly object = new Group();
  private readonly edges: { group: Group; axis: 0 | 1 | 2; sides: [number, number] }[] = [];

  constructor(paint: MarkPaint) {
    for (const axis of [0, 1, 2] as const) {
      for (const first of [-1, 1]) {
        for (const second of [-1, 1]) {
          const group = twoParts(kEdge, paint);
          this.edges.push({ group, axis, sides: [first, second] });
          this.object.add(group);
        }
      }
    }
  }

  // half_m: half the length of an edge.
  set(centre: Vector3, half_m: number, width_m: number): void {
    this.object.position.copy(centre);
    for (const { group, axis, sides } of this.edges) {
      const others = [0, 1, 2].filter((other) => other !== axis);
      const size = [width_m, width_m, width_m];
      size[axis] = 2 * half_m + width_m;
      const place = [0, 0, 0];
      others.forEach((other, i) => (place[other] = (sides[i] ?? 0) * half_m));
      group.position.fromArray(place);
      group.scale.fromArray(size);
    }
  }
}
