#include "io/gltf/contours.h"

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/extras.h"
#include "io/gltf/json.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kStart = "start_m";
constexpr const char* kEnd = "end_m";
constexpr const char* kForm =
    "write \"palpate_contour\": {\"start_m\": [x, y, z], \"end_m\": [x, y, z]}, in metres and in "
    "the frame of the node";

struct ContourPoints {
  Vec3 start_node_m;
  Vec3 end_node_m;
};

Result<Vec3> read_point(const Json& contour, const std::string& parent_element, const char* name) {
  const std::string element = parent_element + "/" + name;
  const auto point = contour.find(name);
  if (point == contour.end()) return gltf_invalid(element, "is missing; expected three numbers");
  if (!point->is_array()) return gltf_expected(element, *point, "a list of three numbers");
  if (point->size() != 3) {
    return gltf_invalid(element,
                        "has " + std::to_string(point->size()) + " elements; expected 3 numbers");
  }
  Vec3 read;
  for (int axis = 0; axis < 3; ++axis) {
    const Json& number = (*point)[static_cast<std::size_t>(axis)];
    if (!number.is_number()) {
      return gltf_expected(element + "/" + std::to_string(axis), number, "a number");
    }
    read[axis] = number.get<double>();  // finite, as in read_number()
  }
  return read;
}

Result<ContourPoints> read_points(const Json& contour, const std::string& element) {
  if (!contour.is_object()) {
    return gltf_expected(element, contour, "an object with start_m and end_m");
  }
  for (const auto& [name, value] : contour.items()) {
    if (name == kStart || name == kEnd) continue;
    return gltf_invalid(
        element, "has the unknown member " + in_quotes(name) + "; expected only start_m and end_m");
  }
  const auto start = read_point(contour, element, kStart);
  if (!start) return start.error();
  const auto end = read_point(contour, element, kEnd);
  if (!end) return end.error();
  return ContourPoints{*start, *end};
}

}  // namespace

ContourDescription read_contour(const GltfAsset& asset, const PlacedNode& placed,
                                const std::string& name) {
  ContourDescription contour;
  contour.node = name;
  contour.element = gltf_element("nodes", placed.node, "extras/palpate_contour");
  contour.tree_node = placed.tree_node;
  const Json& extras = *find_extras(asset.json["nodes"][placed.node]);
  const auto points = read_points(extras["palpate_contour"], contour.element);
  if (!points) {
    contour.element = points.error().element;
    contour.problem = points.error().problem;
    contour.hint = kForm;
    return contour;
  }
  contour.start_scene_m = placed.T_scene_node.point(points->start_node_m);
  contour.end_scene_m = placed.T_scene_node.point(points->end_node_m);
  check_points(contour);
  return contour;
}

}  // namespace palpate
