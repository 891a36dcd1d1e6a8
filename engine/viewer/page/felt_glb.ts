// Reads /felt.glb: the meshes of the compiled scene, one a body. The file has neither textures nor
// compression, so that a small reader of its own suffices.

import { BufferAttribute, BufferGeometry, Matrix4 } from "three";

const kMagic = 0x46546c67; // "glTF"
const kJsonChunk = 0x4e4f534a;
const kBinaryChunk = 0x004e4942;
const kFloat = 5126;

interface Accessor {
  bufferView: number;
  byteOffset?: number;
  componentType: number;
  count: number;
  type: string;
}

interface Gltf {
  accessors: Accessor[];
  bufferViews: { byteOffset?: number; byteLength: number }[];
  meshes: { primitives: { attributes: Record<string, number>; indices?: number }[] }[];
  nodes: { name?: string; mesh?: number; matrix?: number[]; extras?: { body?: number } }[];
}

// A body at rest: its triangles in its own frame, and T_scene_body.
export interface FeltBody {
  body: number;
  geometry: BufferGeometry;
  T_scene_body: Matrix4;
}

function chunks(buffer: ArrayBuffer): { gltf: Gltf; binary: DataView } {
  const view = new DataView(buffer);
  if (view.byteLength < 20 || view.getUint32(0, true) !== kMagic) {
    throw new Error("felt.glb: is no GLB file");
  }
  const jsonBytes = view.getUint32(12, true);
  if (view.getUint32(16, true) !== kJsonChunk) throw new Error("felt.glb: has no JSON chunk first");
  const gltf = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, jsonBytes))) as Gltf;
  const at = 20 + jsonBytes;
  if (view.byteLength < at + 8 || view.getUint32(at + 4, true) !== kBinaryChunk) {
    throw new Error("felt.glb: has no binary chunk");
  }
  return { gltf, binary: new DataView(buffer, at + 8, view.getUint32(at, true)) };
}

function component(binary: DataView, type: number, offset: number): number {
  if (type === 5121) return binary.getUint8(offset);
  if (type === 5123) return binary.getUint16(offset, true);
  return binary.getUint32(offset, true);
}

function values(gltf: Gltf, binary: DataView, index: number): Float32Array | Uint32Array {
  const accessor = gltf.accessors[index];
  const bufferView = accessor && gltf.bufferViews[accessor.bufferView];
  if (!accessor || !bufferView) throw new Error(`felt.glb: accessor ${index} has no data`);
  const begin = (bufferView.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
  const count = accessor.count * (accessor.type === "VEC3" ? 3 : 1);
  if (accessor.componentType === kFloat) {
    const floats = new Float32Array(count);
    for (let i = 0; i < count; ++i) floats[i] = binary.getFloat32(begin + 4 * i, true);
    return floats;
  }
  const bytes = { 5121: 1, 5123: 2, 5125: 4 }[accessor.componentType] ?? 4;
  const indices = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    indices[i] = component(binary, accessor.componentType, begin + bytes * i);
  }
  return indices;
}

// The bodies of the file, in the order of its nodes. Throws an Error that names the fault.
export function readFeltGlb(buffer: ArrayBuffer): FeltBody[] {
  const { gltf, binary } = chunks(buffer);
  const bodies: FeltBody[] = [];
  gltf.nodes.forEach((node, index) => {
    const mesh = node.mesh === undefined ? undefined : gltf.meshes[node.mesh];
    for (const primitive of mesh?.primitives ?? []) {
      const geometry = new BufferGeometry();
      const position = primitive.attributes["POSITION"];
      if (position === undefined) throw new Error(`felt.glb: node ${index} has no POSITION`);
      geometry.setAttribute("position", new BufferAttribute(values(gltf, binary, position), 3));
      if (primitive.indices !== undefined) {
        geometry.setIndex(new BufferAttribute(values(gltf, binary, primitive.indices), 1));
      }
      bodies.push({
        body: node.extras?.body ?? index,
        geometry,
        T_scene_body: node.matrix ? new Matrix4().fromArray(node.matrix) : new Matrix4(),
      });
    }
  });
  return bodies;
}
