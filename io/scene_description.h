#pragma once

// What a scene file says, free of its file format. Made by read_gltf(), consumed by the engine.

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "geometry/types.h"

namespace palpate {

// The triangles of one glTF mesh, its primitives appended in file order.
struct MeshDescription {
  std::string name;
  std::vector<Vec3> positions;      // mesh frame, metres, as in the file (float values)
  std::vector<Triangle> triangles;  // indices into positions
};

// One node of the default scene that carries a mesh.
struct NodeDescription {
  std::string name;        // "node 7" when the file gives none
  std::uint32_t mesh = 0;  // index into SceneDescription::meshes
  // p_scene = linear * p_mesh + translation_m, the product of the node's ancestors in double.
  // Any non-singular linear part: scale, mirror and shear included.
  Mat3 linear_scene_mesh = Mat3::Identity();
  Vec3 translation_m = Vec3::Zero();
};

struct SceneDescription {
  std::string path;                     // the file, as the caller named it
  std::vector<MeshDescription> meshes;  // those of the nodes below, each once, none empty
  std::vector<NodeDescription> nodes;   // those with triangles, in depth-first file order
  std::size_t node_count = 0;           // nodes of the scene, with or without a mesh
  std::vector<std::string> warnings;    // one line each
  double parse_ms = 0.0;
};

}  // namespace palpate
