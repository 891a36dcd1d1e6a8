// Needs PALPATE_MODELS_DIR, the folder of the committed model files.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/scene/scene.h"
#include "models/glb_writer.h"
#include "models/model_files.h"
#include "models/paper_objects.h"
#include "models/primitives.h"
#include "tests/helpers/random.h"

namespace palpate {
namespace {

using test::Random;

// Coordinates have a relative rounding error of 2^-24, and a volume multiplies three coordinates.
constexpr double kFloatVolumeTolerance = 4.0 * 0x1p-24;

// ---- oracles

// The volume by the divergence theorem, in a random pose, so that the result does not depend on the
// frame.
double signed_volume_m3(const TriangleMesh& mesh, const RigidTransform& pose) {
  double sum_m3 = 0.0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 pa = pose.point(mesh.positions_m[a]);
    const Vec3 pb = pose.point(mesh.positions_m[b]);
    sum_m3 += pa.dot(pb.cross(pose.point(mesh.positions_m[c])));
  }
  return sum_m3 / 6.0;
}

// Every edge is traversed once in each direction, every vertex is used, and V - E + F is correct.
void expect_closed(const TriangleMesh& mesh, int euler_characteristic) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> runs;
  std::vector<bool> used(mesh.positions_m.size(), false);
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++runs[{t[k], t[(k + 1) % 3]}];
      used[t[k]] = true;
    }
  }
  std::size_t defects = 0;
  for (const auto& [edge, count] : runs) {
    const auto back = runs.find({edge.second, edge.first});
    if (count != 1 || back == runs.end() || edge.first == edge.second) ++defects;
  }
  EXPECT_EQ(defects, 0u);
  EXPECT_EQ(std::count(used.begin(), used.end(), false), 0);
  const auto v = static_cast<long>(mesh.positions_m.size());
  const auto e = static_cast<long>(runs.size() / 2);
  EXPECT_EQ(v - e + static_cast<long>(mesh.triangles.size()), euler_characteristic);
}

void expect_volume(const TriangleMesh& mesh, double volume_m3, Random& random) {
  const RigidTransform pose{random.rotation(), Vec3::Zero()};
  const double size_m = std::cbrt(volume_m3);
  const RigidTransform moved{pose.rotation, random.in_box(size_m)};
  EXPECT_NEAR(signed_volume_m3(mesh, pose) / volume_m3, 1.0, kFloatVolumeTolerance);
  EXPECT_NEAR(signed_volume_m3(mesh, moved) / volume_m3, 1.0, kFloatVolumeTolerance);
}

void expect_float_coordinates(const TriangleMesh& mesh) {
  for (const Vec3& p : mesh.positions_m) {
    for (const double x : p) ASSERT_EQ(x, static_cast<double>(static_cast<float>(x)));
  }
}

double area_m2(const Contour& contour_m) {
  double twice_m2 = 0.0;
  for (std::size_t i = 0; i < contour_m.size(); ++i) {
    const Point2& a = contour_m[i];
    const Point2& b = contour_m[(i + 1) % contour_m.size()];
    twice_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return twice_m2 / 2.0;
}

double torus_volume_m3(double major_m, double minor_m, double ring, double tube) {
  // A wedge of the polygonal ring is a wedge of revolution, scaled by cos(half)/cos(angle) in its
  // radial direction.
  const double section_m2 =
      tube / 2.0 * std::sin(2.0 * std::numbers::pi / tube) * minor_m * minor_m;
  return ring * std::sin(2.0 * std::numbers::pi / ring) * major_m * section_m2;
}

// ---- a reader independent of the writer ---------------------------------------------------

struct Glb {
  nlohmann::json root;
  TriangleMesh mesh;
};

std::uint32_t little_endian(const std::string& bytes, std::size_t at, std::size_t byte_count) {
  std::uint32_t value = 0;
  for (std::size_t i = byte_count; i-- > 0;) {
    value = value << 8 | static_cast<unsigned char>(bytes.at(at + i));
  }
  return value;
}

std::size_t offset_in_bin(const nlohmann::json& root, const nlohmann::json& accessor) {
  return root["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteOffset"];
}

Glb decode(const std::string& bytes) {
  Glb glb;
  EXPECT_EQ(bytes.substr(0, 4), "glTF");
  EXPECT_EQ(little_endian(bytes, 4, 4), 2u);
  EXPECT_EQ(little_endian(bytes, 8, 4), bytes.size());
  const std::size_t json_size = little_endian(bytes, 12, 4);
  EXPECT_EQ(bytes.substr(16, 4), "JSON");
  glb.root = nlohmann::json::parse(bytes.substr(20, json_size));
  const std::size_t bin = 20 + json_size;
  EXPECT_EQ(bin % 4, 0u);
  EXPECT_EQ(bin + 8 + little_endian(bytes, bin, 4), bytes.size());
  EXPECT_EQ(bytes.substr(bin + 4, 4), std::string("BIN\0", 4));

  const nlohmann::json& primitive = glb.root["meshes"][0]["primitives"][0];
  const nlohmann::json& positions =
      glb.root["accessors"][primitive["attributes"]["POSITION"].get<std::size_t>()];
  std::size_t at = bin + 8 + offset_in_bin(glb.root, positions);
  EXPECT_EQ(positions["componentType"], 5126);
  for (int i = 0; i < positions["count"]; ++i, at += 12) {
    Vec3 p;
    for (int k = 0; k < 3; ++k) p[k] = std::bit_cast<float>(little_endian(bytes, at + 4 * k, 4));
    glb.mesh.positions_m.push_back(p);
  }
  const nlohmann::json& indices = glb.root["accessors"][primitive["indices"].get<std::size_t>()];
  at = bin + 8 + offset_in_bin(glb.root, indices);
  const std::size_t size = indices["componentType"] == 5123 ? 2 : 4;
  for (int i = 0; i < indices["count"]; i += 3, at += 3 * size) {
    glb.mesh.triangles.push_back({little_endian(bytes, at, size),
                                  little_endian(bytes, at + size, size),
                                  little_endian(bytes, at + 2 * size, size)});
  }
  return glb;
}

std::map<std::string, Glb> decoded_models() {
  std::map<std::string, Glb> models;
  const auto files = model_files();
  EXPECT_TRUE(files.ok());
  if (!files) return models;
  for (const ModelFile& file : *files) models[file.file_name] = decode(file.bytes);
  return models;
}

GlbContent content_with(TriangleMesh mesh) {
  return {"thing", "stuff", std::move(mesh)};
}

// ---- contours

Point2 wall_vector(const Contour& contour, std::size_t i) {
  return contour[(i + 1) % contour.size()] - contour[i];
}

double distance_to_wall_m(const Contour& contour, std::size_t wall, const Point2& p) {
  const Point2 along = wall_vector(contour, wall);
  const Point2 from = p - contour[wall];
  const double share = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (from - share * along).norm();
}

// The distance from `origin` along `direction` to the first wall other than `self` and its two
// neighbours; infinite if there is none.
double free_path_m(const Contour& contour, std::size_t self, const Point2& origin,
                   const Point2& direction) {
  const std::size_t n = contour.size();
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < n; ++i) {
    if (i == self || (i + 1) % n == self || i == (self + 1) % n) continue;
    const Point2 along = wall_vector(contour, i);
    const double parallel = direction.x() * along.y() - direction.y() * along.x();
    if (std::abs(parallel) <= 1e-12 * along.norm()) continue;
    const Point2 gap = contour[i] - origin;
    const double path_m = (gap.x() * along.y() - gap.y() * along.x()) / parallel;
    const double share = (gap.x() * direction.y() - gap.y() * direction.x()) / parallel;
    if (path_m > 0.0 && share >= 0.0 && share <= 1.0) nearest_m = std::min(nearest_m, path_m);
  }
  return nearest_m;
}

// The mean angle between the walls' normals and the x axis over one turn in 27 s at constant speed,
// with scene alignment. The object starts at orientation_rad. Alignment rotates it about z by the
// shorter angle, at 5 + (85/30) a deg/s for angles a below 30 deg and at 90 deg/s above. The normal
// is rotated towards the same end of the axis as before, unless it points away from this end by 2
// deg.
double mean_aligned_angle_rad(const Contour& contour, double orientation_rad) {
  const double step_s = 0.001;
  const double degree = std::numbers::pi / 180.0;
  const std::size_t n = contour.size();
  double length_m = 0.0;
  for (std::size_t i = 0; i < n; ++i) length_m += wall_vector(contour, i).norm();
  double turned_rad = orientation_rad;
  double sign = 0.0;
  double sum_rad = 0.0;
  double steps = 0.0;
  for (std::size_t i = 0; i <= n; ++i) {  // visits the first wall in two halves
    const Point2 wall = wall_vector(contour, i % n);
    const double share = i % n == 0 ? 0.5 : 1.0;
    const double wall_s = share * 27.0 * wall.norm() / length_m;
    for (double time_s = 0.0; time_s < wall_s; time_s += step_s, ++steps) {
      const double normal_rad = std::atan2(-wall.x(), wall.y()) + turned_rad;
      if (sign == 0.0) sign = std::cos(normal_rad) < 0.0 ? -1.0 : 1.0;
      if (sign * std::cos(normal_rad) < -std::sin(2.0 * degree)) sign = -sign;
      const double signed_rad =
          std::atan2(sign * std::sin(normal_rad), sign * std::cos(normal_rad));
      const double angle_rad = std::abs(signed_rad);
      sum_rad += std::min(angle_rad, std::numbers::pi - angle_rad);
      const double speed_rad_per_s =
          angle_rad > 30.0 * degree ? 90.0 * degree : 5.0 * degree + 85.0 / 30.0 * angle_rad;
      turned_rad -= std::copysign(std::min(angle_rad, speed_rad_per_s * step_s), signed_rad);
    }
  }
  return sum_rad / steps;
}

// A star-shaped polygon without symmetry.
Contour random_contour(Random& random, std::size_t corners) {
  Contour contour;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2.0 * std::numbers::pi *
                         (static_cast<double>(i) + random.uniform(0.1, 0.9)) /
                         static_cast<double>(corners);
    const double radius_m = random.uniform(0.02, 0.2);
    contour.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle));
  }
  return contour;
}

bool is_right_angled(const Contour& contour) {
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const Point2 wall = wall_vector(contour, i);
    const Point2 next = wall_vector(contour, (i + 1) % contour.size());
    if (wall.x() * next.x() != 0.0 || wall.y() * next.y() != 0.0) return false;
  }
  return true;
}

bool is_inside(const Contour& contour, const Point2& p) {
  bool inside = false;
  for (std::size_t i = 0; i < contour.size(); ++i) {
    const Point2& a = contour[i];
    const Point2& b = contour[(i + 1) % contour.size()];
    if ((a.y() > p.y()) == (b.y() > p.y())) continue;
    const double crossing_x = a.x() + (p.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (p.x() < crossing_x) inside = !inside;
  }
  return inside;
}

// ---- model files

TEST(ModelFiles, EqualTheCommittedFilesByteForByte) {
  const auto files = model_files();
  ASSERT_TRUE(files.ok()) << files.error().to_string();
  ASSERT_EQ(files->size(), 19u);
  for (const ModelFile& file : *files) {
    std::ifstream stream(std::string(PALPATE_MODELS_DIR) + "/" + file.file_name, std::ios::binary);
    ASSERT_TRUE(stream.good()) << file.file_name;
    const std::string committed{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_TRUE(committed == file.bytes) << file.file_name << " differs: run generate_models";
    EXPECT_LT(committed.size(), 300'000u) << file.file_name;
  }
}

TEST(ModelFiles, AreClosedAndOutwardWithTheVolumeOfTheirShape) {
  Random random(1);
  std::map<std::string, double> volume_m3 = {
      {"cube.glb", 1.0},
      {"thin_plate.glb", 0.2 * 0.2 * 0.001},
      {"torus.glb", torus_volume_m3(1.0, 0.25, 128.0, 64.0)}};
  for (const PaperObject& object : paper_objects()) {
    volume_m3[object.name + ".glb"] = area_m2(object.contour_m) * 0.04;
  }
  const auto models = decoded_models();
  for (const auto& [name, volume] : volume_m3) {
    SCOPED_TRACE(name);
    ASSERT_EQ(models.count(name), 1u);
    const TriangleMesh& mesh = models.at(name).mesh;
    expect_closed(mesh, name == "torus.glb" ? 0 : 2);
    expect_volume(mesh, volume, random);
  }
}

TEST(ModelFiles, SphereHas20480TrianglesOnTheUnitSphere) {
  const auto models = decoded_models();
  ASSERT_EQ(models.count("sphere.glb"), 1u);
  const TriangleMesh& mesh = models.at("sphere.glb").mesh;
  EXPECT_EQ(mesh.triangles.size(), 20480u);
  expect_closed(mesh, 2);
  for (const Vec3& p : mesh.positions_m) ASSERT_NEAR(p.norm(), 1.0, 0x1p-23);
}

TEST(ModelFiles, ContainTheStartAndEndOfATurnAlongTheContour) {
  const auto models = decoded_models();
  for (const PaperObject& object : paper_objects()) {
    ASSERT_EQ(models.count(object.name + ".glb"), 1u);
    const auto& node = models.at(object.name + ".glb").root["nodes"][0];
    const ContourRoute route = contour_route(object.contour_m);
    const nlohmann::json& extras = node["extras"]["palpate_contour"];
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(extras["start_m"][static_cast<std::size_t>(k)], route.start_m[k]);
      EXPECT_EQ(extras["end_m"][static_cast<std::size_t>(k)], route.end_m[k]);
    }
    const auto scene = Scene::load(std::string(PALPATE_MODELS_DIR "/") + object.name + ".glb");
    ASSERT_TRUE(scene.ok()) << scene.error().to_string();
    EXPECT_TRUE(scene->statistics().warnings.empty());
    ASSERT_EQ(scene->contours().size(), 1u);
    EXPECT_EQ(scene->contours()[0].problem, "");
    EXPECT_EQ(scene->contours()[0].start_scene_m, route.start_m);
    EXPECT_EQ(scene->contours()[0].end_scene_m, route.end_m);
  }
  EXPECT_FALSE(models.at("sphere.glb").root["nodes"][0].contains("extras"));
}

// ---- paper objects

TEST(PaperObjects, HaveAtMost16CornersAndRightAnglesInLabyrinths) {
  for (const PaperObject& object : paper_objects()) {
    SCOPED_TRACE(object.name);
    EXPECT_LE(object.contour_m.size(), 16u);
    const bool labyrinth = object.name.find("labyrinth") != std::string::npos;
    EXPECT_EQ(is_right_angled(object.contour_m), labyrinth);
    EXPECT_GT(area_m2(object.contour_m), 0.0) << "clockwise";
  }
}

TEST(PaperObjects, KeepWalls25MillimetresLongAnd20Apart) {
  for (const PaperObject& object : paper_objects()) {
    SCOPED_TRACE(object.name);
    const Contour& contour = object.contour_m;
    const std::size_t n = contour.size();
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_GE(wall_vector(contour, i).norm(), 0.025 * (1.0 - 1e-9)) << "wall " << i;
      for (std::size_t j = 0; j < n; ++j) {
        if (j == i || j == (i + 1) % n) continue;
        EXPECT_GE(distance_to_wall_m(contour, i, contour[j]), 0.02) << i << " " << j;
      }
    }
  }
}

// Walls with separate ends could still cross.
TEST(PaperObjects, AreSimplePolygons) {
  for (const PaperObject& object : paper_objects()) {
    const Contour& contour = object.contour_m;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const Point2 wall = wall_vector(contour, i);
      const double path_m = free_path_m(contour, i, contour[i], wall.normalized());
      EXPECT_GT(path_m, wall.norm()) << object.name << ": wall " << i << " is crossed";
    }
  }
}

TEST(PaperObjects, HaveAClearanceOf30MillimetresInFrontOfEveryWall) {
  for (const PaperObject& object : paper_objects()) {
    const Contour& contour = object.contour_m;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      const Point2 wall = wall_vector(contour, i);
      const Point2 outward = Point2(wall.y(), -wall.x()).normalized();
      for (double share = 0.001; share < 1.0; share += 0.0025) {
        const double path_m = free_path_m(contour, i, contour[i] + share * wall, outward);
        EXPECT_GE(path_m, 0.03 * (1.0 - 1e-9)) << object.name << ": wall " << i;
      }
    }
  }
}

TEST(PaperObjects, HaveAMeanAngleAbove42DegreesToAFixedLineInEveryOrientation) {
  for (const PaperObject& object : paper_objects()) {
    for (int orientation_deg = 0; orientation_deg < 180; ++orientation_deg) {
      const double mean_rad =
          mean_contact_angle_rad(object.contour_m, orientation_deg * std::numbers::pi / 180.0);
      EXPECT_GT(mean_rad * 180.0 / std::numbers::pi, 42.0)
          << object.name << " at " << orientation_deg;
      EXPECT_LT(mean_rad * 180.0 / std::numbers::pi, 48.0)
          << object.name << " at " << orientation_deg;
    }
  }
}

// The ranges in models/MODELS.md, and the bound of 33 deg that the evaluation assumes.
TEST(PaperObjects, HaveASmallMeanAngleToTheAxisWithAlignment) {
  const std::array<std::array<double, 2>, 4> range_deg = {
      {{8.0, 10.0}, {22.9, 24.8}, {21.3, 23.2}, {17.9, 19.8}}};
  for (std::size_t i = 0; i < range_deg.size(); ++i) {
    const PaperObject object = paper_objects()[i];
    for (int orientation_deg = 0; orientation_deg < 360; orientation_deg += 5) {
      const double mean_deg =
          mean_aligned_angle_rad(object.contour_m, orientation_deg * std::numbers::pi / 180.0) *
          180.0 / std::numbers::pi;
      EXPECT_GT(mean_deg, range_deg[i][0]) << object.name << " at " << orientation_deg;
      EXPECT_LT(mean_deg, range_deg[i][1]) << object.name << " at " << orientation_deg;
    }
  }
}

TEST(PaperObjects, CanBeFollowedInHalfAMinute) {
  for (const PaperObject& object : paper_objects()) {
    double length_m = 0.0;
    for (std::size_t i = 0; i < object.contour_m.size(); ++i) {
      length_m += wall_vector(object.contour_m, i).norm();
    }
    EXPECT_GE(length_m, 0.5) << object.name;
    EXPECT_LE(length_m, 1.2) << object.name;
  }
}

TEST(PaperObjects, StartAndEndOnTheFirstWall20MillimetresApart) {
  for (const PaperObject& object : paper_objects()) {
    SCOPED_TRACE(object.name);
    const ContourRoute route = contour_route(object.contour_m);
    const Point2 start(route.start_m.x(), route.start_m.y());
    const Point2 end(route.end_m.x(), route.end_m.y());
    const Point2 wall = wall_vector(object.contour_m, 0);
    EXPECT_LT(distance_to_wall_m(object.contour_m, 0, start), 1e-12 * wall.norm());
    EXPECT_LT(distance_to_wall_m(object.contour_m, 0, end), 1e-12 * wall.norm());
    EXPECT_NEAR((start - end).dot(wall.normalized()), 0.02, 1e-12);
    EXPECT_NEAR((start + end - 2.0 * object.contour_m[0]).norm(), wall.norm(), 1e-12);
    EXPECT_EQ(route.start_m.z(), 0.0);
    EXPECT_EQ(route.end_m.z(), 0.0);
  }
}

TEST(PaperObjects, InvertedLabyrinthFitsIntoTheLabyrinthWithoutGapOrOverlap) {
  const Contour labyrinth = labyrinth_contour();
  const Contour inverted = inverted_labyrinth_contour();
  const double cell_m = 0.032;
  // The 4 x 4 cells that both shapes cover after the inverted labyrinth is moved one cell left and
  // down.
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const Point2 middle(cell_m * (column - 2.0), cell_m * (row - 2.0));
      const Point2 moved = middle + Point2(cell_m, cell_m);
      EXPECT_NE(is_inside(labyrinth, middle), is_inside(inverted, moved)) << column << " " << row;
    }
  }
}

TEST(MeanContactAngle, IsTheAngleOfTheWallsOfAThinStrip) {
  // A strip 1 m by 1 um along x: its long walls' normals lie along y.
  const Contour strip = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1e-6}, {0.0, 1e-6}};
  for (const double angle_rad : {0.0, 0.3, -0.3, 1.2, 2.0, 10.0}) {
    const double folded_rad = std::abs(std::remainder(angle_rad, std::numbers::pi));
    EXPECT_NEAR(mean_contact_angle_rad(strip, angle_rad), std::numbers::pi / 2.0 - folded_rad,
                1e-5);
  }
}

// ---- primitives

TEST(Icosphere, HasFourTimesTheTrianglesPerLevelAndIsClosed) {
  std::size_t triangles = 20;
  for (int level = 0; level <= 5; ++level, triangles *= 4) {
    const TriangleMesh mesh = icosphere(level, 0.1);
    EXPECT_EQ(mesh.triangles.size(), triangles);
    expect_closed(mesh, 2);
    expect_float_coordinates(mesh);
  }
}

TEST(Icosphere, IsAnIcosahedronAtLevelZero) {
  Random random(2);
  const double radius_m = 0.37;
  const double edge_m = radius_m / std::sin(0.4 * std::numbers::pi);
  const double volume_m3 = 5.0 / 12.0 * (3.0 + std::sqrt(5.0)) * std::pow(edge_m, 3.0);
  expect_volume(icosphere(0, radius_m), volume_m3, random);
}

TEST(Icosphere, ApproachesTheVolumeOfTheSphereFromBelowInSecondOrder) {
  const double sphere_m3 = 4.0 / 3.0 * std::numbers::pi;
  double coarser_error = 0.0;
  for (int level = 2; level <= 6; ++level) {
    const double error = 1.0 - signed_volume_m3(icosphere(level, 1.0), {}) / sphere_m3;
    EXPECT_GT(error, 0.0);
    if (level > 2) {
      EXPECT_NEAR(std::log2(coarser_error / error), 2.0, 0.05) << level;
    }
    coarser_error = error;
  }
}

TEST(BumpySphere, IsClosedWithBumpsWithinTheirHeight) {
  const double radius_m = 0.1;
  const double height_m = 0.01;
  const TriangleMesh mesh = bumpy_sphere(5, radius_m, height_m, 8);
  expect_closed(mesh, 2);
  expect_float_coordinates(mesh);
  double lowest_m = radius_m;
  double highest_m = radius_m;
  for (const Vec3& p : mesh.positions_m) {
    lowest_m = std::min(lowest_m, p.norm());
    highest_m = std::max(highest_m, p.norm());
  }
  EXPECT_GE(lowest_m, (radius_m - height_m) * (1.0 - 0x1p-22));
  EXPECT_LE(highest_m, (radius_m + height_m) * (1.0 + 0x1p-22));
  EXPECT_GT(highest_m - lowest_m, height_m);
  for (const Triangle& t : mesh.triangles) {  // radial everywhere: no triangle is reversed
    const Vec3& a = mesh.positions_m[t[0]];
    ASSERT_GT(a.dot(mesh.positions_m[t[1]].cross(mesh.positions_m[t[2]])), 0.0);
  }
}

TEST(BumpySphere, IsTheProductOfCosinesOfTheAnglesToTheAxes) {
  const int waves = 5;
  for (const Vec3& p : bumpy_sphere(3, 1.0, 0.1, waves).positions_m) {
    const Vec3 u = p.normalized();
    double bump = 1.0;
    for (const double x : u) bump *= std::cos(waves * std::acos(std::clamp(x, -1.0, 1.0)));
    ASSERT_NEAR(p.norm(), 1.0 + 0.1 * bump, 1e-6);
  }
}

TEST(Box, IsClosedOutwardAndCentred) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Vec3 size_m(random.uniform(0.001, 1.0), random.uniform(0.1, 1.0),
                      random.uniform(0.1, 9.0));
    const TriangleMesh mesh = box(size_m);
    expect_closed(mesh, 2);
    expect_volume(mesh, size_m.prod(), random);
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : mesh.positions_m) sum += p;
    EXPECT_EQ(sum.norm(), 0.0);
  }
}

TEST(Torus, HasTheVolumeOfThePolygonalRing) {
  Random random(4);
  for (int level = 0; level <= 4; ++level) {
    const TriangleMesh mesh = torus(0.3, 0.1, level);
    EXPECT_EQ(mesh.triangles.size(), std::size_t{64} << 2 * level);
    expect_closed(mesh, 0);
    expect_float_coordinates(mesh);
    expect_volume(mesh, torus_volume_m3(0.3, 0.1, 8 << level, 4 << level), random);
  }
}

TEST(Prism, HasTheVolumeOfItsContourTimesItsHeight) {
  Random random(5);
  for (int trial = 0; trial < 300; ++trial) {
    const Contour contour = random_contour(random, 5 + random.index(60));
    const auto mesh = prism(contour, -0.03, 0.05);
    ASSERT_TRUE(mesh.ok()) << mesh.error().to_string();
    EXPECT_EQ(mesh->triangles.size(), 4 * contour.size() - 4);
    expect_closed(*mesh, 2);
    expect_float_coordinates(*mesh);
    const double height_m = static_cast<double>(0.05f) + static_cast<double>(0.03f);
    Contour rounded;
    for (std::size_t i = 0; i < contour.size(); ++i) {
      rounded.emplace_back(mesh->positions_m[i].x(), mesh->positions_m[i].y());
    }
    expect_volume(*mesh, area_m2(rounded) * height_m, random);
  }
}

// The caps are tested directly, because a reversed triangle would cancel in the volume.
TEST(Prism, TriangulatesCapsWithOutwardTriangles) {
  Random random(6);
  for (int trial = 0; trial < 100; ++trial) {
    const std::size_t n = 5 + random.index(60);
    const auto mesh = prism(random_contour(random, n), 0.0, 1.0);
    ASSERT_TRUE(mesh.ok());
    for (std::size_t i = 2 * n; i < mesh->triangles.size(); ++i) {
      const auto& [a, b, c] = mesh->triangles[i];
      const Vec3& pa = mesh->positions_m[a];
      const double twice_m2 = (mesh->positions_m[b] - pa).cross(mesh->positions_m[c] - pa).z();
      ASSERT_GT(pa.z() > 0.5 ? twice_m2 : -twice_m2, 0.0);
    }
  }
}

TEST(Prism, AcceptsStraightCornersAndVerticesOnOneLine) {
  // A comb on a grid: every tooth has a vertex at half its height, and the corners of all teeth lie
  // on one line.
  Contour comb = {{0.0, 0.0}, {21.0, 0.0}};
  for (int x = 21; x >= 1; x -= 4) {
    comb.insert(comb.end(), {{x + 0.0, 3.0}, {x + 0.0, 5.0}, {x - 1.0, 5.0}, {x - 1.0, 3.0}});
    if (x > 1) comb.insert(comb.end(), {{x - 1.0, 1.0}, {x - 4.0, 1.0}});
  }
  // The corner with the shortest cut, at the origin, has a notch on this cut.
  const Contour notched = {{0.0, 0.0}, {1.0, 1.0},  {4.0, 4.5},  {4.0, 5.0},
                           {0.0, 1.0}, {-4.0, 5.0}, {-4.0, 4.5}, {-1.0, 1.0}};
  Random random(7);
  for (const Contour& contour : {comb, notched}) {
    const auto mesh = prism(contour, 0.0, 2.0);
    ASSERT_TRUE(mesh.ok()) << mesh.error().to_string();
    expect_closed(*mesh, 2);
    expect_volume(*mesh, 2.0 * area_m2(contour), random);
  }
}

TEST(Prism, RejectsContoursThatAreNotSimpleOrNotCounterClockwise) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Contour square = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
  const std::vector<std::pair<std::string, Contour>> refused = {
      {"empty", {}},
      {"two vertices", {{0.0, 0.0}, {1.0, 0.0}}},
      {"clockwise", Contour(square.rbegin(), square.rend())},
      {"bow-tie", {{0.0, 0.0}, {1.0, 1.0}, {1.0, 0.0}, {0.0, 1.0}}},
      {"repeated vertex", {{0.0, 0.0}, {1.0, 0.0}, {1.0, 0.0}, {0.0, 1.0}}},
      {"no area", {{0.0, 0.0}, {1.0, 0.0}, {2.0, 0.0}}},
      {"spike", {{0.0, 0.0}, {2.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}}},
      {"vertex on a wall", {{0.0, 0.0}, {2.0, 0.0}, {2.0, 2.0}, {1.0, 0.0}, {0.0, 2.0}}},
      {"two squares at a corner",
       {{0.0, 0.0},
        {1.0, 0.0},
        {1.0, 1.0},
        {2.0, 1.0},
        {2.0, 2.0},
        {1.0, 2.0},
        {1.0, 1.0},
        {0.0, 1.0}}},
      {"equal once rounded to float", {{1.0, 0.0}, {1.0 + 1e-12, 1e-60}, {0.0, 1.0}}},
      {"beyond float", {{0.0, 0.0}, {1e300, 0.0}, {0.0, 1.0}}},
      {"not a number", {{0.0, 0.0}, {1.0, nan}, {0.0, 1.0}}}};
  for (const auto& [what, contour] : refused) {
    const auto mesh = prism(contour, 0.0, 1.0);
    ASSERT_FALSE(mesh.ok()) << what;
    EXPECT_EQ(mesh.error().code, ErrorCode::kInvalidArgument) << what;
  }
  EXPECT_TRUE(prism(square, 0.0, 1.0).ok());
  EXPECT_FALSE(prism(square, 1.0, 1.0).ok());
  EXPECT_FALSE(prism(square, 0.0, nan).ok());
}

// Triangles with two distant corners on one ray from the origin and the third corner beside the
// ray. The area is at most 2^-40 of the products in its formula, which a double cannot resolve.
TEST(Prism, UsesExactOrientation) {
  Random random(9);
  const auto integer = [&](double bound) { return std::round(random.uniform(-bound, bound)); };
  for (int trial = 0; trial < 2000; ++trial) {
    const Point2 direction(integer(0x1p24), integer(0x1p24));
    const Point2 beside(integer(4.0), integer(4.0));
    const Contour sliver = {0x1p38 * direction, beside, 0x1p34 * direction};
    const Contour reversed(sliver.rbegin(), sliver.rend());
    // The area is a positive multiple of this, which is exact.
    const double turn = direction.x() * beside.y() - direction.y() * beside.x();
    ASSERT_EQ(prism(sliver, 0.0, 1.0).ok(), turn > 0.0);
    ASSERT_EQ(prism(reversed, 0.0, 1.0).ok(), turn < 0.0);
  }
}

// ---- GLB writer

TEST(GlbWriter, WritesContentThatAReaderReadsBack) {
  Random random(8);
  const TriangleMesh mesh = bumpy_sphere(2, random.uniform(0.1, 10.0), 0.01, 3);
  const nlohmann::json extras = {{"a", {{"b", 0.1}}}};
  const auto bytes = encode_glb(content_with(mesh), extras);
  ASSERT_TRUE(bytes.ok());
  const Glb glb = decode(*bytes);
  EXPECT_EQ(glb.mesh.positions_m, mesh.positions_m);
  EXPECT_EQ(glb.mesh.triangles, mesh.triangles);
  EXPECT_EQ(glb.root["asset"]["version"], "2.0");
  EXPECT_EQ(glb.root["nodes"][0]["extras"], extras);
  EXPECT_EQ(glb.root["nodes"][0]["name"], "thing");
  EXPECT_EQ(glb.root["materials"][0]["name"], "stuff");
  EXPECT_EQ(glb.root["scenes"][0]["nodes"], nlohmann::json::array({0}));
  for (int k = 0; k < 3; ++k) {
    const auto by_axis = [k](const Vec3& a, const Vec3& b) { return a[k] < b[k]; };
    const auto [low, high] =
        std::minmax_element(mesh.positions_m.begin(), mesh.positions_m.end(), by_axis);
    EXPECT_EQ(glb.root["accessors"][0]["min"][static_cast<std::size_t>(k)], (*low)[k]);
    EXPECT_EQ(glb.root["accessors"][0]["max"][static_cast<std::size_t>(k)], (*high)[k]);
  }
}

TEST(GlbWriter, Uses16BitIndicesUpToTheReservedValueAnd32BitBeyond) {
  TriangleMesh mesh;
  mesh.positions_m.assign(0xffff, Vec3(1.0, 2.0, 3.0));
  mesh.triangles = {{0, 1, 0xfffe}};
  const auto small = encode_glb(content_with(mesh), {});
  mesh.positions_m.emplace_back(4.0, 5.0, 6.0);
  mesh.triangles = {{0, 1, 0xffff}};
  const auto large = encode_glb(content_with(mesh), {});
  ASSERT_TRUE(small.ok() && large.ok());
  EXPECT_EQ(decode(*small).root["accessors"][1]["componentType"], 5123);
  EXPECT_EQ(decode(*large).root["accessors"][1]["componentType"], 5125);
  EXPECT_EQ(decode(*small).mesh.triangles[0][2], 0xfffeu);
  EXPECT_EQ(decode(*large).mesh.triangles[0][2], 0xffffu);
}

TEST(GlbWriter, RejectsAMeshThatNoReaderAccepts) {
  const TriangleMesh good = box({1.0, 1.0, 1.0});
  TriangleMesh empty = good;
  empty.triangles.clear();
  TriangleMesh dangling = good;
  dangling.triangles[3][1] = 8;
  TriangleMesh infinite = good;
  infinite.positions_m[2].y() = 1e39;  // finite as a double only
  ASSERT_TRUE(encode_glb(content_with(good), {}).ok());
  for (const TriangleMesh& bad : {empty, dangling, infinite}) {
    const auto bytes = encode_glb(content_with(bad), {});
    ASSERT_FALSE(bytes.ok());
    EXPECT_EQ(bytes.error().code, ErrorCode::kInvalidArgument);
  }
}

TEST(GlbWriter, ReportsAFileThatCannotBeWritten) {
  const std::string path = testing::TempDir() + "palpate_no_such_folder/model.glb";
  const auto written = write_file(path, "x");
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kFileUnwritable);
  EXPECT_EQ(written.error().path, path);
}

}  // namespace
}  // namespace palpate
