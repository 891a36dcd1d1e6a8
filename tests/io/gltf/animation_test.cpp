// Animations at any time, compared with an independent sampler in long double; and the choice of an
// animation.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/helpers/floating_point.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/random.h"
#include "tests/helpers/sanitizers.h"
#include "tests/io/gltf/reading.h"

namespace palpate {
namespace {

using Json = nlohmann::json;
using test::add_floats;
using test::add_numbers;
using test::expect_refused;
using test::GltfBuilder;
using test::kEpsilon;
using test::read_glb;

using Long = long double;
using LongMatrix = Eigen::Matrix<Long, 4, 4>;
using LongVector = Eigen::Matrix<Long, 4, 1>;
using Numbers = std::vector<Long>;

ReadOptions posed(const std::string& pose) {
  ReadOptions options;
  options.pose = pose;
  return options;
}

// Seconds as in an option, with all digits.
std::string text_of(double seconds) {
  std::array<char, 64> text;
  std::snprintf(text.data(), text.size(), "%.17g", seconds);
  return text.data();
}

// ---- the formulas of glTF 2.0, appendix C, unchanged --------------------------------------------

enum class Kind { kStep, kLinear, kCubicSpline };
constexpr std::array<Kind, 3> kKinds = {Kind::kStep, Kind::kLinear, Kind::kCubicSpline};

const char* name_of(Kind kind) {
  return kind == Kind::kStep ? "STEP" : kind == Kind::kLinear ? "LINEAR" : "CUBICSPLINE";
}

// The keys of one channel in the file, as exact numbers.
struct Curve {
  Kind kind = Kind::kLinear;
  bool is_rotation = false;
  std::vector<float> times;
  std::vector<Numbers> values, in, out;  // by key; tangents of splines only
};

Numbers normalized(Numbers q) {
  Long square = 0.0L;
  for (const Long x : q) square += x * x;
  for (Long& x : q) x /= std::sqrt(square);
  return q;
}

Numbers slerped(const Numbers& from, const Numbers& to, Long t) {
  const Numbers a = normalized(from);
  const Numbers b = normalized(to);
  Long d = 0.0L;
  for (std::size_t i = 0; i < 4; ++i) d += a[i] * b[i];
  const Long angle = std::acos(std::min(std::abs(d), 1.0L));
  const Long sign = d < 0.0L ? -1.0L : 1.0L;
  Numbers q(4);
  for (std::size_t i = 0; i < 4; ++i) {
    // For angles near zero the formula is linear.
    q[i] = std::sin(angle) < 1e-9L
               ? (1.0L - t) * a[i] + t * sign * b[i]
               : (std::sin(angle * (1.0L - t)) * a[i] + sign * std::sin(angle * t) * b[i]) /
                     std::sin(angle);
  }
  return q;
}

Numbers sampled(const Curve& curve, double time) {
  if (time <= curve.times.front()) return curve.values.front();
  if (time >= curve.times.back()) return curve.values.back();
  std::size_t k = 0;
  while (time >= curve.times[k + 1]) ++k;
  const Long td = static_cast<Long>(curve.times[k + 1]) - curve.times[k];
  const Long t = (static_cast<Long>(time) - curve.times[k]) / td;
  const Numbers& a = curve.values[k];
  const Numbers& b = curve.values[k + 1];
  if (curve.kind == Kind::kStep) return a;
  if (curve.kind == Kind::kLinear && curve.is_rotation) return slerped(a, b, t);
  Numbers value(a.size());
  for (std::size_t i = 0; i < value.size(); ++i) {
    value[i] = curve.kind == Kind::kLinear
                   ? (1 - t) * a[i] + t * b[i]
                   : (2 * t * t * t - 3 * t * t + 1) * a[i] +
                         td * (t * t * t - 2 * t * t + t) * curve.out[k][i] +
                         (-2 * t * t * t + 3 * t * t) * b[i] +
                         td * (t * t * t - t * t) * curve.in[k + 1][i];
  }
  return curve.is_rotation ? normalized(value) : value;
}

// ---- random animations --------------------------------------------------------------------------

struct Format {
  int component_type;
  Long largest;  // the integer for 1; 0 for floats
  bool is_signed;
};
constexpr std::array<Format, 5> kFormats = {{{GltfBuilder::kFloat, 0.0L, true},
                                             {GltfBuilder::kByte, 127.0L, true},
                                             {GltfBuilder::kUnsignedByte, 255.0L, false},
                                             {GltfBuilder::kShort, 32767.0L, true},
                                             {GltfBuilder::kUnsignedShort, 65535.0L, false}}};

// A component after it is stored and read again.
Long stored(double x, const Format& format) {
  if (format.largest == 0.0L) return static_cast<float>(x);
  const double clamped = std::clamp(format.is_signed ? x : std::abs(x), -1.0, 1.0);
  return std::round(clamped * static_cast<double>(format.largest)) / format.largest;
}

template <typename T>
std::size_t add_integers(GltfBuilder& asset, const Numbers& numbers, const Format& format,
                         const std::string& type) {
  std::vector<T> stored;
  for (const Long x : numbers) stored.push_back(static_cast<T>(std::llround(x * format.largest)));
  return add_numbers(asset, stored, format.component_type, type, true);
}

std::size_t add_stored(GltfBuilder& asset, const Numbers& numbers, const Format& format,
                       const std::string& type) {
  switch (format.component_type) {
    case GltfBuilder::kByte:
      return add_integers<std::int8_t>(asset, numbers, format, type);
    case GltfBuilder::kUnsignedByte:
      return add_integers<std::uint8_t>(asset, numbers, format, type);
    case GltfBuilder::kShort:
      return add_integers<std::int16_t>(asset, numbers, format, type);
    case GltfBuilder::kUnsignedShort:
      return add_integers<std::uint16_t>(asset, numbers, format, type);
    default:
      return add_floats(asset, std::vector<float>(numbers.begin(), numbers.end()), type);
  }
}

// Node 0 with node 1 below it, and node 2 below that, which carries a mesh with two morph targets;
// node 3 carries a mesh whose three vertices follow the three others as joints. All are animated.
class RandomClip {
 public:
  RandomClip(test::Random& random, Kind kind) : random_(random), kind_(kind) {
    const std::vector<Eigen::Vector3f> base = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    base_ = base;
    const auto positions = asset.add_positions(base);
    for (auto& target : targets_) {
      for (int i = 0; i < 3; ++i) target.push_back(random_.in_box(1.0).cast<float>());
    }
    asset.json["meshes"] = {
        {{"primitives",
          {{{"attributes", {{"POSITION", positions}}},
            {"targets",
             {{{"POSITION", asset.add_positions(targets_[0])}},
              {{"POSITION", asset.add_positions(targets_[1])}}}}}}}},
        {{"primitives",
          {{{"attributes",
             {{"POSITION", positions},
              {"JOINTS_0",
               add_numbers(asset, std::vector<std::uint8_t>{0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0},
                           GltfBuilder::kUnsignedByte, "VEC4")},
              {"WEIGHTS_0", add_floats(asset, {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4")}}}}}}}};
    asset.add_node({{"children", {1}}});
    asset.add_child({{"children", {2}}, {"scale", {1, 2, 1}}});
    asset.add_child({{"mesh", 0}, {"weights", {0.5, 0.25}}});
    asset.add_node({{"mesh", 1}, {"skin", 0}});
    asset.json["skins"] = {{{"joints", {0, 1, 2}}}};
    // Another animation of the same nodes, which must have no effect.
    asset.json["animations"] = Json::array();
    add_animation("Other");
    add_animation("Clip");
  }

  // Checks the pose at a time against the formulas.
  void check(double time) const {
    SCOPED_TRACE(std::string(name_of(kind_)) + " at " + text_of(time));
    const SceneDescription scene = read_glb(asset, posed("Clip@" + text_of(time)));
    ASSERT_EQ(scene.nodes.size(), 2u);
    ASSERT_TRUE(scene.pose);
    EXPECT_EQ(scene.pose->animation, 1u);
    EXPECT_EQ(scene.pose->time_s, time);
    std::array<LongMatrix, 3> worlds;
    LongMatrix world = LongMatrix::Identity();
    Long size = 1.0L;
    for (std::size_t n = 0; n < 3; ++n) {
      const LongMatrix local = local_at(n, time);
      world = world * local;
      size *= std::max(local.norm(), 1.0L);
      worlds[n] = world;
    }
    const Long bound = kRoundings * kEpsilon * size;
    const Mat3& linear = scene.nodes[0].linear_scene_mesh;
    const Eigen::Matrix<Long, 3, 3> expected = world.topLeftCorner<3, 3>();
    EXPECT_LE((linear.cast<Long>() - expected).norm(), bound);
    const Eigen::Matrix<Long, 3, 1> translation = world.topRightCorner<3, 1>();
    EXPECT_LE((scene.nodes[0].translation_m.cast<Long>() - translation).norm(), bound);
    const Numbers weights = sampled(weights_, time);
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Matrix<Long, 3, 1> morphed = base_[i].cast<Long>() +
                                                weights[0] * targets_[0][i].cast<Long>() +
                                                weights[1] * targets_[1][i].cast<Long>();
      EXPECT_LE((scene.meshes.at(0).positions[i].cast<Long>() - morphed).norm(),
                kRoundings * kEpsilon * 4.0L);
      const LongVector skinned = worlds[i] * base_[i].cast<Long>().homogeneous();
      EXPECT_LE((scene.meshes.at(1).positions[i].cast<Long>() - skinned.head<3>()).norm(), bound);
    }
  }

  const std::vector<float>& times() const { return weights_.times; }

  GltfBuilder asset;

 private:
  // For a sampled value, a rotation matrix and products of four matrices. Subtracting times costs a
  // spline's tangents as many digits as an interval is shorter than the times.
  static constexpr Long kRoundings = 256.0L;
  static constexpr std::size_t kKeys = 6;
  struct NodeCurves {
    Curve translation, rotation, scale;
  };

  LongMatrix local_at(std::size_t node, double time) const {
    const NodeCurves& curves = curves_[node];
    const Numbers t = sampled(curves.translation, time);
    const Numbers q = sampled(curves.rotation, time);
    const Numbers s = sampled(curves.scale, time);
    Eigen::Quaternion<Long> rotation(q[3], q[0], q[1], q[2]);
    rotation.normalize();
    LongMatrix m = LongMatrix::Identity();
    m.topLeftCorner<3, 3>() =
        rotation.toRotationMatrix() * Eigen::Matrix<Long, 3, 1>(s[0], s[1], s[2]).asDiagonal();
    m.topRightCorner<3, 1>() << t[0], t[1], t[2];
    return m;
  }

  void add_animation(const char* name) {
    const std::size_t id = asset.json["animations"].size();
    asset.json["animations"].push_back({{"name", name}});
    std::vector<float> times = {static_cast<float>(random_.uniform(0.0, 1.0))};
    while (times.size() < kKeys) {
      times.push_back(times.back() + static_cast<float>(random_.uniform(0.1, 1.0)));
    }
    for (std::size_t n = 0; n < 3; ++n) {
      curves_[n].translation = add_curve(id, n, "translation", 3, kFormats[0], times);
      curves_[n].scale = add_curve(id, n, "scale", 3, kFormats[0], times);
      curves_[n].rotation = add_curve(id, n, "rotation", 4, any_format(), times);
    }
    weights_ = add_curve(id, 2, "weights", 2, any_format(), times);
  }

  const Format& any_format() { return kFormats[random_.index(kFormats.size())]; }

  // For a rotation, a unit quaternion as exact as the format allows.
  Numbers random_value(const Curve& curve, std::size_t width, const Format& format) {
    for (;;) {
      Numbers value;
      const Eigen::Vector4d q = random_.rotation().coeffs();
      Long square = 0.0L;
      for (std::size_t i = 0; i < width; ++i) {
        value.push_back(stored(curve.is_rotation ? q[i] : random_.uniform(-1.0, 1.0), format));
        square += value.back() * value.back();
      }
      if (!curve.is_rotation || std::abs(std::sqrt(square) - 1.0L) < 1.0L / 256.0L) return value;
    }
  }

  Numbers random_tangent(std::size_t width, const Format& format) {
    Numbers tangent;
    for (std::size_t i = 0; i < width; ++i) {
      tangent.push_back(stored(random_.uniform(-0.3, 0.3), format));
    }
    return tangent;
  }

  Curve add_curve(std::size_t animation, std::size_t node, const std::string& path,
                  std::size_t width, const Format& format, const std::vector<float>& times) {
    Curve curve{kind_, path == "rotation", times, {}, {}, {}};
    Numbers numbers;
    for (std::size_t k = 0; k < kKeys; ++k) {
      curve.values.push_back(random_value(curve, width, format));
      curve.in.push_back(random_tangent(width, format));
      curve.out.push_back(random_tangent(width, format));
      const bool is_cubic = kind_ == Kind::kCubicSpline;
      if (is_cubic) numbers.insert(numbers.end(), curve.in[k].begin(), curve.in[k].end());
      numbers.insert(numbers.end(), curve.values[k].begin(), curve.values[k].end());
      if (is_cubic) numbers.insert(numbers.end(), curve.out[k].begin(), curve.out[k].end());
    }
    const char* type = path == "weights" ? "SCALAR" : width == 4 ? "VEC4" : "VEC3";
    Json& json = asset.json["animations"][animation];
    const std::size_t sampler = json["samplers"].size();
    json["samplers"].push_back({{"input", add_floats(asset, times, "SCALAR")},
                                {"output", add_stored(asset, numbers, format, type)},
                                {"interpolation", name_of(kind_)}});
    json["channels"].push_back(
        {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
    return curve;
  }

  test::Random& random_;
  Kind kind_;
  std::vector<Eigen::Vector3f> base_;
  std::array<std::vector<Eigen::Vector3f>, 2> targets_;
  std::array<NodeCurves, 3> curves_;  // of the animation that was added last
  Curve weights_;
};

TEST(GltfKeyframes, PoseNodesMorphTargetsAndJointsByTheFormulasOfTheSpecification) {
  constexpr int kRounds = test::kHasAddressSanitizer ? 5 : 30;  // each takes 2 s there
  test::Random random(21);
  for (int round = 0; round < kRounds; ++round) {
    for (const Kind kind : kKinds) {
      const RandomClip clip(random, kind);
      const std::vector<float>& times = clip.times();
      clip.check(0.0);
      clip.check(0.5 * times.front());
      for (std::size_t k = 0; k < times.size(); ++k) {
        clip.check(times[k]);
        if (k > 0) clip.check(random.uniform(times[k - 1], times[k]));
      }
      clip.check(times.back() + random.uniform(0.0, 100.0));
      clip.check(1e300);
    }
  }
}

// ---- one node -----------------------------------------------------------------------------------

// A triangle whose node has one channel.
GltfBuilder moving_triangle(const std::string& path, const std::vector<float>& times,
                            const std::vector<float>& values,
                            const std::string& interpolation = "LINEAR") {
  GltfBuilder asset = GltfBuilder::one_triangle();
  const auto output = add_floats(asset, values, path == "rotation" ? "VEC4" : "VEC3");
  asset.json["animations"] = {
      {{"name", "Move"},
       {"samplers",
        {{{"input", add_floats(asset, times, "SCALAR")},
          {"output", output},
          {"interpolation", interpolation}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}}};
  return asset;
}

double x_at(const GltfBuilder& asset, const std::string& time) {
  return read_glb(asset, posed("Move@" + time)).nodes.at(0).translation_m.x();
}

TEST(GltfKeyframes, HoldTheFirstValueBeforeAndTheLastValueAfterTheirKeys) {
  for (const Kind kind : kKinds) {
    std::vector<float> values = {3, 0, 0, 7, 0, 0};
    if (kind == Kind::kCubicSpline) {
      values = {9, 9, 9, 3, 0, 0, 9, 9, 9, 9, 9, 9, 7, 0, 0, 9, 9, 9};
    }
    const GltfBuilder asset = moving_triangle("translation", {1, 2}, values, name_of(kind));
    for (const char* time : {"0", "0.5", "1", "1e-320"}) EXPECT_EQ(x_at(asset, time), 3.0) << time;
    for (const char* time : {"2", "2.5", "1e308"}) EXPECT_EQ(x_at(asset, time), 7.0) << time;
  }
}

TEST(GltfKeyframes, MayHaveAnyNumberOfKeysFromOne) {
  for (const char* time : {"0", "1", "2"}) {
    EXPECT_EQ(x_at(moving_triangle("translation", {1}, {3, 0, 0}), time), 3.0);
    EXPECT_EQ(
        x_at(moving_triangle("translation", {1}, {1, 1, 1, 3, 0, 0, 1, 1, 1}, "CUBICSPLINE"), time),
        3.0);
  }
}

TEST(GltfKeyframes, RotateAlongTheShorterArcAndStayBetweenEqualRotations) {
  const float h = std::sqrt(0.5f);
  // A quarter turn about z, stored as the negated quaternion: halfway is 45 degrees, not 315.
  const GltfBuilder asset = moving_triangle("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, -h, -h});
  const Mat3 half_way = read_glb(asset, posed("Move@0.5")).nodes.at(0).linear_scene_mesh;
  const double quarter_pi = std::atan(1.0);
  EXPECT_LE((half_way - Eigen::AngleAxisd(quarter_pi, Vec3::UnitZ()).toRotationMatrix()).norm(),
            1e-15);
  const GltfBuilder still = moving_triangle("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, -1});
  EXPECT_EQ(read_glb(still, posed("Move@0.3")).nodes.at(0).linear_scene_mesh, Mat3::Identity());
}

TEST(GltfKeyframes, RejectASplineThroughAZeroQuaternion) {
  const GltfBuilder asset = moving_triangle(
      "rotation", {0, 1}, {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0},
      "CUBICSPLINE");
  EXPECT_EQ(read_glb(asset, posed("Move@0.25")).nodes.at(0).linear_scene_mesh, Mat3::Identity());
  expect_refused(asset, ErrorCode::kInvalidContent, "/animations/0/samplers/0/output", "0.5",
                 posed("Move@0.5"));
}

TEST(GltfKeyframes, WarnOfDecreasingTimesAndIgnoreKeysBeforeAnEarlierTime) {
  const GltfBuilder asset =
      moving_triangle("translation", {0, 2, 1, 3}, {0, 0, 0, 50, 0, 0, 10, 0, 0, 30, 0, 0});
  for (const auto& [time, x] : std::vector<std::pair<const char*, double>>{
           {"0", 0}, {"0.5", 5}, {"1", 10}, {"2", 20}, {"2.5", 25}, {"3", 30}}) {
    EXPECT_EQ(x_at(asset, time), x) << time;
  }
  const SceneDescription scene = read_glb(asset, posed("Move@0"));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_EQ(scene.warnings[0],
            "/animations/0/samplers/0/input: key 2 at 1.000000 s is earlier than the previous key; "
            "expected increasing times. Keys are ignored if a key with an earlier time follows");
  EXPECT_TRUE(read_glb(asset).warnings.empty());
}

TEST(GltfKeyframes, WarnOfTwoKeysAtOneTimeAndStepThere) {
  const GltfBuilder asset =
      moving_triangle("translation", {0, 1, 1, 2}, {0, 0, 0, 10, 0, 0, 50, 0, 0, 60, 0, 0});
  for (const auto& [time, x] :
       std::vector<std::pair<const char*, double>>{{"0.5", 5}, {"1", 50}, {"1.5", 55}, {"2", 60}}) {
    EXPECT_EQ(x_at(asset, time), x) << time;
  }
  const SceneDescription scene = read_glb(asset, posed("Move@0"));
  ASSERT_EQ(scene.warnings.size(), 1u);
  EXPECT_NE(scene.warnings[0].find("key 2 at 1.000000 s has the time of"), std::string::npos);
  EXPECT_NE(scene.warnings[0].find("The last of several keys at one time is used"),
            std::string::npos);
  // All keys at one time: the first holds before, the last from then on.
  const GltfBuilder one = moving_triangle("translation", {1, 1}, {10, 0, 0, 50, 0, 0});
  EXPECT_EQ(x_at(one, "0.5"), 10.0);
  EXPECT_EQ(x_at(one, "1"), 50.0);
}

// Times that no valid file has, compared with the rule that the warning states.
TEST(GltfKeyframes, ReadAnyOrderOfTimesAsTheWarningStates) {
  test::Random random(22);
  for (int round = 0; round < 200; ++round) {
    std::vector<float> times, values;
    for (std::size_t k = 0; k < 1 + random.index(8); ++k) {
      times.push_back(static_cast<float>(random.index(6)));
      values.insert(values.end(), {static_cast<float>(random.index(100)), 0, 0});
    }
    const GltfBuilder asset = moving_triangle("translation", times, values);
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] <=
          *std::min_element(times.begin() + static_cast<std::ptrdiff_t>(i), times.end())) {
        kept.push_back(i);
      }
    }
    const double time = 0.5 * static_cast<double>(random.index(14));
    double expected = values[3 * kept.front()];
    for (std::size_t n = 0; n < kept.size(); ++n) {
      const std::size_t i = kept[n];
      if (times[i] > time) break;
      expected = values[3 * i];
      if (n + 1 == kept.size()) break;
      const std::size_t j = kept[n + 1];
      if (times[j] <= time) continue;
      expected += (time - times[i]) / (times[j] - times[i]) * (values[3 * j] - values[3 * i]);
    }
    EXPECT_NEAR(x_at(asset, text_of(time)), expected, 1e-12) << "round " << round;
  }
}

TEST(GltfKeyframes, CostNoMoreIfManyChannelsShareASampler) {
  GltfBuilder asset = moving_triangle("translation", {0, 1}, {1, 0, 0, 2, 0, 0});
  for (std::size_t n = 1; n < 2000; ++n) {
    asset.add_node({{"mesh", 0}});
    asset.json["animations"][0]["channels"].push_back(
        {{"sampler", 0}, {"target", {{"node", n}, {"path", "translation"}}}});
  }
  const SceneDescription scene = read_glb(asset, posed("Move@0.5"));
  ASSERT_EQ(scene.nodes.size(), 2000u);
  for (const NodeDescription& node : scene.nodes) EXPECT_EQ(node.translation_m, Vec3(1.5, 0, 0));
}

// ---- choosing -----------------------------------------------------------------------------------

// Four clips of one node, which put it at x = 10, 20, 30 and 40; the second and the fourth have one
// name, the third has none.
GltfBuilder four_clips() {
  GltfBuilder asset = moving_triangle("translation", {0, 1}, {10, 0, 0, 10, 0, 0});
  const Json first = asset.json["animations"][0];
  for (int i = 1; i < 4; ++i) {
    const float x = 10.0f * static_cast<float>(i + 1);
    const auto values = add_floats(asset, {x, 0, 0, x, 0, 0}, "VEC3");
    const auto times = add_floats(asset, {0, 0.25f * static_cast<float>(i)}, "SCALAR");
    asset.json["animations"].push_back(first);
    asset.json["animations"][i]["samplers"][0]["output"] = values;
    asset.json["animations"][i]["samplers"][0]["input"] = times;
    asset.json["animations"][i]["name"] = "Twice";
  }
  asset.json["animations"][0]["name"] = "a@1";
  asset.json["animations"][2].erase("name");
  return asset;
}

TEST(GltfPose, IsChosenByNameOrNumberBeforeTheLastAtSign) {
  const GltfBuilder asset = four_clips();
  for (const auto& [pose, x] : std::vector<std::pair<const char*, double>>{{"a@1@0", 10},
                                                                           {"#0@0.5", 10},
                                                                           {"#1@7", 20},
                                                                           {"animation 2@1", 30},
                                                                           {"#2@0.0", 30},
                                                                           {"#3@1e-3", 40},
                                                                           {"", 0}}) {
    EXPECT_EQ(read_glb(asset, posed(pose)).nodes.at(0).translation_m.x(), x) << pose;
  }
}

TEST(GltfPose, PrefersANameToANumber) {
  GltfBuilder asset = four_clips();
  asset.json["animations"][3]["name"] = "#0";
  EXPECT_EQ(read_glb(asset, posed("#0@0")).nodes.at(0).translation_m.x(), 40.0);
}

TEST(GltfPose, RejectsAnUnknownAnimationAndListsTheAnimations) {
  const GltfBuilder asset = four_clips();
  const std::string all =
      "choose from #0 \"a@1\" of 1 s, #1 \"Twice\" of 0.25 s, #2 \"animation 2\" of 0.5 s, #3 "
      "\"Twice\" of 0.75 s";
  for (const char* pose :
       {"walk@0", "#4@0",  "#-1@0",  "#@0",     "#1x@0",   "#99999999999999999999@0",
        " a@1@0", "@0",    "a@",     "a",       "#0",      "#0@",
        "#0@x",   "#0@-1", "#0@nan", "#0@inf",  "#0@-inf", "#0@1e999",
        "#0@1s",  "#0@ 1", "#0@1 ",  "#0@0x10", "#0@1,5",  "animation 0@0"}) {
    expect_refused(asset, ErrorCode::kInvalidArgument, "pose \"" + std::string(pose) + "\"", all,
                   posed(pose));
  }
  expect_refused(asset, ErrorCode::kInvalidArgument, "pose \"Twice@0\"",
                 "name the animation by its number in the file: \"#1\", \"#3\"", posed("Twice@0"));
  expect_refused(GltfBuilder::one_triangle(), ErrorCode::kInvalidArgument, "pose \"Walk@0\"",
                 "the file has no animation", posed("Walk@0"));
}

TEST(GltfPose, NamesAFewOfManyAnimations) {
  GltfBuilder asset = four_clips();
  const Json clip = asset.json["animations"][1];
  while (asset.json["animations"].size() < 100) asset.json["animations"].push_back(clip);
  expect_refused(asset, ErrorCode::kInvalidArgument, "pose \"walk@0\"", "and 92 more",
                 posed("walk@0"));
  expect_refused(asset, ErrorCode::kInvalidArgument, "pose \"Twice@0\"", "and 90 more",
                 posed("Twice@0"));
}

TEST(GltfPose, StatesInANoteTheAnimationAndItsLastKey) {
  const GltfBuilder asset = four_clips();
  const auto note = [&](const char* pose) { return read_glb(asset, posed(pose)).notes.at(0); };
  EXPECT_EQ(note(""), "pose: at rest");
  EXPECT_EQ(note("#3@0.5"), "pose: animation #3 \"Twice\" at 0.5 s");
  EXPECT_EQ(note("#3@2"), "pose: animation #3 \"Twice\" at 2 s, after its last key at 0.75 s");
}

TEST(GltfPose, ListsAllAnimationsWithTheirLengthsEvenIfInvalid) {
  GltfBuilder asset = four_clips();
  Json& animations = asset.json["animations"];
  animations[0]["samplers"][0]["input"] = 999;
  animations[1]["channels"] = "none";
  animations[2]["samplers"].push_back(animations[3]["samplers"][0]);  // no channel uses it
  animations[3]["channels"].push_back({{"sampler", 1}, {"target", {{"path", "pointer"}}}});
  animations[3]["samplers"].push_back(
      {{"input", add_floats(asset, {0, 9, 5}, "SCALAR")}, {"output", 0}});
  animations.push_back(7);
  const auto list = read_glb(asset).animations;
  ASSERT_EQ(list.size(), 5u);
  EXPECT_EQ(list[0].name, "a@1");
  EXPECT_FALSE(list[0].length_s);
  EXPECT_FALSE(list[1].length_s);
  EXPECT_EQ(list[2].length_s, 0.5);
  EXPECT_EQ(list[3].length_s, 9.0);
  EXPECT_EQ(list[4].name, "animation 4");
  EXPECT_FALSE(list[4].length_s);
}

}  // namespace
}  // namespace palpate
