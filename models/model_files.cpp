#include "models/model_files.h"

#include <array>
#include <utility>

#include <nlohmann/json.hpp>

#include "models/effect_scenes.h"
#include "models/glb_writer.h"
#include "models/paper_objects.h"
#include "models/primitives.h"

namespace palpate {
namespace {

struct Model {
  std::string name;
  TriangleMesh mesh;
  nlohmann::json node_extras;  // null for none
};

nlohmann::json route_extras(const Contour& contour_m) {
  const auto coordinates = [](const Vec3& p) { return std::array<double, 3>{p.x(), p.y(), p.z()}; };
  const ContourRoute route = contour_route(contour_m);
  return {{"palpate_contour",
           {{"start_m", coordinates(route.start_m)}, {"end_m", coordinates(route.end_m)}}}};
}

}  // namespace

Result<std::vector<ModelFile>> model_files() {
  std::vector<Model> models;
  for (const PaperObject& object : paper_objects()) {
    const double top_m = kPaperObjectHeight_m / 2.0;
    Result<TriangleMesh> mesh = prism(object.contour_m, -top_m, top_m);
    if (!mesh) return mesh.error();
    models.push_back({object.name, std::move(*mesh), route_extras(object.contour_m)});
  }
  models.push_back({"sphere", icosphere(5, 1.0), {}});
  models.push_back({"cube", box({1.0, 1.0, 1.0}), {}});
  models.push_back({"torus", torus(1.0, 0.25, 4), {}});
  models.push_back({"thin_plate", box({0.2, 0.2, 0.001}), {}});

  std::vector<ModelFile> files;
  for (Model& model : models) {
    Result<std::string> bytes =
        encode_glb({model.name, "solid", std::move(model.mesh)}, model.node_extras);
    if (!bytes) return bytes.error();
    files.push_back({model.name + ".glb", std::move(*bytes)});
  }
  for (const EffectScene& scene : effect_scenes()) {
    Result<std::string> bytes = encode_scene(scene.content);
    if (!bytes) {
      Error error = bytes.error();
      error.path = scene.name;
      return error;
    }
    files.push_back({scene.name + ".glb", std::move(*bytes)});
  }
  return files;
}

}  // namespace palpate
