#include "engine/scene/felt_glb.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <meshoptimizer.h>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloatComponent = 5126;
constexpr int kUint32Component = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

// A body's surface in its body frame, metres.
struct BodyMesh {
  std::vector<std::array<float, 3>> corners;
  std::vector<std::uint32_t> indices;
};

BodyMesh mesh_of(const Scene& scene, std::size_t object) {
  const SurfaceMesh& surface = scene.mesh(scene.objects()[object].mesh);
  const AffineMap map = scene.deformation(object);
  BodyMesh mesh;
  mesh.corners.reserve(surface.welded_positions().size());
  for (const Vec3& p : surface.welded_positions()) {
    const Eigen::Vector3f corner = map(p).cast<float>();
    mesh.corners.push_back({corner.x(), corner.y(), corner.z()});
  }
  const bool is_mirrored = map.linear.determinant() < 0.0;
  mesh.indices.reserve(3 * surface.face_count());
  for (const Triangle& t : surface.faces()) {
    mesh.indices.insert(mesh.indices.end(), {t[0], t[is_mirrored ? 2 : 1], t[is_mirrored ? 1 : 2]});
  }
  return mesh;
}

// Removes corners without a triangle.
void compact(BodyMesh& mesh) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> place(mesh.corners.size(), kNone);
  std::vector<std::array<float, 3>> kept;
  for (std::uint32_t& corner : mesh.indices) {
    if (place[corner] == kNone) {
      place[corner] = static_cast<std::uint32_t>(kept.size());
      kept.push_back(mesh.corners[corner]);
    }
    corner = place[corner];
  }
  mesh.corners = std::move(kept);
}

void simplify(BodyMesh& mesh, std::size_t triangles) {
  if (mesh.indices.size() <= 3 * triangles) return;
  std::vector<std::uint32_t> kept(mesh.indices.size());
  constexpr float kAnyError = 1.0f;  // relative to the extent: the number of triangles decides
  kept.resize(meshopt_simplify(kept.data(), mesh.indices.data(), mesh.indices.size(),
                               mesh.corners.front().data(), mesh.corners.size(),
                               sizeof mesh.corners.front(), 3 * triangles, kAnyError));
  if (kept.empty()) return;
  mesh.indices = std::move(kept);
  compact(mesh);
}

// The column-major matrix of a pose.
std::array<double, 16> matrix_of(const RigidTransform& T) {
  const Mat3 R = T.rotation.toRotationMatrix();
  std::array<double, 16> matrix{};
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      matrix[static_cast<std::size_t>(4 * column + row)] = R(row, column);
    }
    matrix[static_cast<std::size_t>(12 + column)] = T.translation_m[column];
  }
  matrix[15] = 1.0;
  return matrix;
}

// Collects the parts of the asset.
class Asset {
 public:
  Asset() : json_({{"asset", {{"version", "2.0"}, {"generator", "palpate"}}}, {"scene", 0}}) {
    for (const char* list : {"scenes", "nodes", "meshes", "accessors", "bufferViews"}) {
      json_[list] = Json::array();
    }
  }

  void add(const BodyMesh& mesh, const SceneObject& object, std::size_t body) {
    const std::size_t positions = add_positions(mesh);
    const std::size_t indices = add_indices(mesh);
    const Json primitive = {{"attributes", {{"POSITION", positions}}}, {"indices", indices}};
    json_["meshes"].push_back({{"primitives", Json::array({primitive})}});
    json_["nodes"].push_back({{"name", object.name},
                              {"mesh", json_["meshes"].size() - 1},
                              {"matrix", matrix_of(object.T_scene_body)},
                              {"extras", {{"body", body}}}});
  }

  // The GLB: a header, a chunk of JSON and a chunk of numbers.
  Result<std::string> finish() && {
    Json roots = Json::array();
    for (std::size_t i = 0; i < json_["nodes"].size(); ++i) roots.push_back(i);
    json_["scenes"].push_back(roots.empty() ? Json::object() : Json{{"nodes", roots}});
    json_["buffers"] = Json::array({{{"byteLength", numbers_.size()}}});
    // A name that is not UTF-8 gets replacement characters.
    std::string json = json_.dump(-1, ' ', false, Json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::uint64_t total = 12 + 8 + json.size() + 8 + numbers_.size();
    if (total > std::numeric_limits<std::uint32_t>::max()) {
      return Error{ErrorCode::kLimitExceeded, "", "scene",
                   "needs more than 4 GiB as a GLB; expected less", "show a part of the scene"};
    }
    std::string glb;
    glb.reserve(total);
    put_words(glb, {0x46546C67u, 2u, static_cast<std::uint32_t>(total)});
    put_words(glb, {static_cast<std::uint32_t>(json.size()), 0x4E4F534Au});
    glb += json;
    put_words(glb, {static_cast<std::uint32_t>(numbers_.size()), 0x004E4942u});
    glb += numbers_;
    return glb;
  }

 private:
  static void put_words(std::string& out, std::initializer_list<std::uint32_t> words) {
    for (const std::uint32_t word : words) {
      char bytes[sizeof word];
      std::memcpy(bytes, &word, sizeof word);
      out.append(bytes, sizeof word);
    }
  }

  std::size_t add_view(const void* data, std::size_t bytes, int target) {
    json_["bufferViews"].push_back({{"buffer", 0},
                                    {"byteOffset", numbers_.size()},
                                    {"byteLength", bytes},
                                    {"target", target}});
    numbers_.append(static_cast<const char*>(data), bytes);
    return json_["bufferViews"].size() - 1;
  }

  std::size_t add_positions(const BodyMesh& mesh) {
    std::array<float, 3> low = mesh.corners.front();
    std::array<float, 3> high = low;
    for (const auto& corner : mesh.corners) {
      for (std::size_t k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], corner[k]);
        high[k] = std::max(high[k], corner[k]);
      }
    }
    const std::size_t view = add_view(
        mesh.corners.data(), mesh.corners.size() * sizeof(mesh.corners.front()), kArrayBuffer);
    json_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", kFloatComponent},
                                  {"count", mesh.corners.size()},
                                  {"type", "VEC3"},
                                  {"min", low},
                                  {"max", high}});
    return json_["accessors"].size() - 1;
  }

  std::size_t add_indices(const BodyMesh& mesh) {
    const std::size_t view =
        add_view(mesh.indices.data(), mesh.indices.size() * sizeof(mesh.indices.front()),
                 kElementArrayBuffer);
    json_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", kUint32Component},
                                  {"count", mesh.indices.size()},
                                  {"type", "SCALAR"}});
    return json_["accessors"].size() - 1;
  }

  Json json_;
  std::string numbers_;
};

std::size_t share_of(std::size_t triangles, std::size_t most, std::size_t all) {
  const double share = static_cast<double>(most) / static_cast<double>(all);
  return std::max<std::size_t>(1, static_cast<std::size_t>(static_cast<double>(triangles) * share));
}

}  // namespace

Result<FeltGlb> encode_felt_scene(const Scene& scene, std::size_t most_triangles) {
  FeltGlb felt;
  for (const SceneObject& object : scene.objects()) {
    felt.triangles += scene.mesh(object.mesh).face_count();
  }
  const bool is_simplified = most_triangles > 0 && felt.triangles > most_triangles;
  Asset asset;
  for (std::size_t body = 0; body < scene.objects().size(); ++body) {
    BodyMesh mesh = mesh_of(scene, body);
    if (is_simplified) {
      simplify(mesh, share_of(mesh.indices.size() / 3, most_triangles, felt.triangles));
    }
    if (mesh.indices.empty()) continue;
    felt.shown_triangles += mesh.indices.size() / 3;
    asset.add(mesh, scene.objects()[body], body);
  }
  auto bytes = std::move(asset).finish();
  if (!bytes) return bytes.error();
  felt.bytes = std::move(*bytes);
  return felt;
}

}  // namespace palpate
