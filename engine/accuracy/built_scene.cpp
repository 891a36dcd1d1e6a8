#include "engine/accuracy/built_scene.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include "engine/accuracy/error_measures.h"

namespace palpate {

Result<std::shared_ptr<const Scene>> compile_mesh(TriangleMesh mesh, double proxy_radius_m,
                                                  const Vec3& place_m) {
  SceneDescription description;
  description.meshes.push_back({"mesh", std::move(mesh.positions_m), std::move(mesh.triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = "mesh";
  description.nodes.back().translation_m = place_m;
  description.tree.resize(1);
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  Result<Scene> scene = Scene::compile(std::move(description), settings);
  if (!scene) return scene.error();
  return std::make_shared<const Scene>(std::move(*scene));
}

std::shared_ptr<const Scene> mesh_scene(TriangleMesh mesh, double proxy_radius_m,
                                        const Vec3& place_m) {
  const auto scene = compile_mesh(std::move(mesh), proxy_radius_m, place_m);
  if (!scene) {
    std::fprintf(stderr, "palpate: %s\n", scene.error().to_string().c_str());
    std::abort();
  }
  return *scene;
}

double file_floor_m(const Scene& scene) {
  double farthest_m = 0.0;
  for (std::size_t i = 0; i < scene.objects().size(); ++i) {
    const ContactBody& body = scene.world().bodies[i];
    const Box box = body.box_body();
    const Vec3 origin = scene.map_body_mesh(i).translation_m;  // of the mesh frame
    const Vec3 reach_m = body.length_to_solver(1.0) *
                         (box.low - origin).cwiseAbs().cwiseMax((box.high - origin).cwiseAbs());
    farthest_m = std::max(farthest_m, reach_m.maxCoeff());
  }
  return float_floor_m(farthest_m);
}

std::string triangles_label(std::size_t triangles) {
  const auto count = static_cast<double>(triangles);
  char text[40];
  if (triangles < 1000) {
    std::snprintf(text, sizeof text, "%zu triangles", triangles);
  } else if (triangles < 2000) {
    std::snprintf(text, sizeof text, "%.1fk triangles", 1e-3 * count);
  } else if (triangles < 1000000) {
    std::snprintf(text, sizeof text, "%.0fk triangles", 1e-3 * count);
  } else {
    std::snprintf(text, sizeof text, "%.1fM triangles", 1e-6 * count);
  }
  return text;
}

double mean_edge_m(const TriangleMesh& mesh) {
  double sum_m = 0.0;
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      sum_m += (mesh.positions_m[t[(e + 1) % 3]] - mesh.positions_m[t[e]]).norm();
    }
  }
  return sum_m / (3.0 * static_cast<double>(mesh.triangles.size()));
}

}  // namespace palpate
