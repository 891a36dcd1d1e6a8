// What a tick touches, and when a touch begins and ends. In random scenes, a second god-object
// makes the moves of the loop again. Its contacts, and the parts of the lag that they bear,
// computed here in long double, say which body and which material the record must name.

#include "haptics/touch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "haptics/effects/cones_of_effects.h"
#include "haptics/haptic_loop.h"
#include "tests/helpers/compiled_scene.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"
#include "tests/helpers/worlds.h"

namespace palpate {
namespace {

using test::Random;

constexpr double kTick_s = 1e-3;

// Boxes that overlap, each with up to three runs of materials.
struct TouchScene {
  Scene scene;
  bool has_friction = false;
};

MaterialDescription material(int number, bool has_friction, SeededRandom& random) {
  MaterialDescription made{
      "material " + std::to_string(number), "/materials/" + std::to_string(number), {}, {}};
  const auto add = [&](const char* key, double value) {
    made.parameters.push_back({key, value, made.element + "/extras/palpate/" + key});
  };
  if (has_friction) add("dynamicFriction", random.uniform(0.05, 0.5));
  if (number % 2 == 0) add("stiffness", random.uniform(300.0, 900.0));
  std::sort(made.parameters.begin(), made.parameters.end(),
            [](const auto& a, const auto& b) { return a.key < b.key; });
  return made;
}

TouchScene made_scene(SeededRandom& random, double radius_m) {
  constexpr std::uint32_t kMaterials = 5;
  SceneDescription description;
  description.path = "touch.glb";
  const bool has_friction = random.index(2) == 0;
  for (std::uint32_t m = 0; m < kMaterials; ++m) {
    description.materials.push_back(material(static_cast<int>(m), has_friction, random));
  }
  const auto bodies = static_cast<std::uint32_t>(4 + random.index(9));
  for (std::uint32_t b = 0; b < bodies; ++b) {
    const Vec3 half_m(random.uniform(0.005, 0.02), random.uniform(0.005, 0.02),
                      random.uniform(0.005, 0.02));
    test::Soup soup = test::box_soup(half_m);
    if (random.index(2) == 0) {  // concave: two of its own faces can hold the proxy
      const Vec3 shift_m = random.in_box(0.015);
      const test::Soup other = test::box_soup(half_m);
      const auto first = static_cast<std::uint32_t>(soup.positions.size());
      for (const Vec3& p : other.positions) soup.positions.push_back(p + shift_m);
      for (const Triangle& t : other.triangles) {
        soup.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
      }
    }
    MeshDescription mesh{"box", std::move(soup.positions), std::move(soup.triangles)};
    std::uint32_t next = random.index(4) == 0 ? 2 : 0;  // faces without a material come first
    for (; next < mesh.triangles.size(); next += 1 + static_cast<std::uint32_t>(random.index(6))) {
      const auto m = static_cast<std::uint32_t>(random.index(kMaterials + 1));
      mesh.material_runs.push_back({next, m < kMaterials ? std::optional(m) : std::nullopt});
      if (random.index(3) == 0) break;
    }
    const RigidTransform pose{random.index(2) == 0 ? Quat(Quat::Identity()) : random.rotation(),
                              random.in_box(0.03)};
    const std::string name = "box " + std::to_string(b);
    description.tree.push_back({name, b, {}, true, pose.translation_m});
    NodeDescription node{name, b, pose.rotation.toRotationMatrix(), pose.translation_m};
    node.tree_node = b;
    description.nodes.push_back(node);
    description.meshes.push_back(std::move(mesh));
  }
  SceneSettings settings;
  settings.proxy_radius_m = radius_m;
  return {test::compiled(std::move(description), settings), has_friction};
}

// Makes the moves of a loop again, from the records alone.
class Mirror {
 public:
  Mirror(const TouchScene& touched, const HapticSettings& settings, bool is_planar)
      : world_(touched.scene.world()),
        is_planar_(is_planar),
        god_(test::made(GodObject::create(world_, settings.god_object))) {
    if (!touched.has_friction) return;
    effects_ =
        std::make_unique<EffectRunner>(world_, settings.god_object, settings.coupling, false);
  }

  void move_body(std::uint32_t body, const RigidTransform& T_scene_body) {
    const RigidTransform T{T_scene_body.rotation.normalized(),
                           world_.to_solver(T_scene_body.translation_m)};
    const auto known = std::find_if(motions_.begin(), motions_.end(),
                                    [&](const BodyMotion& m) { return m.body == body; });
    if (known == motions_.end()) {
      motions_.push_back({body, T});
    } else {
      known->T_solver_body = T;
    }
    have_arrived_ = false;
  }

  ProxyState follow(const TickRecord& record) {
    if ((record.faults & kFaultsWithoutForce) != 0) {
      god_.end_friction();
      return {};
    }
    std::optional<Vec3> plane;
    const Mat3 R_device_scene = pose_before(record).rotation.toRotationMatrix();
    if (is_planar_) plane = R_device_scene.transpose().col(2);
    move_bodies(plane);
    goal_m_ = world_.to_solver(vec3(record.goal_scene_m));
    if (!std::exchange(is_placed_, true)) {
      god_.place(goal_m_, plane);
      if (effects_) effects_->begin_tick();
      if (effects_) finish_effects();
      return {};
    }
    return effects_ ? move_with_effects(record, plane) : god_.move_to(goal_m_, plane);
  }

  const GodObject& god() const { return god_; }
  Vec3 lag_m() const { return god_.proxy() - goal_m_; }

 private:
  // Far from all effects, the loop moves without friction (HapticLoop::begin_effects).
  ProxyState move_with_effects(const TickRecord& record, const std::optional<Vec3>& plane) {
    if (effects_->is_far_from_all(god_.world(), god_.proxy(), goal_m_)) {
      return god_.move_to(goal_m_, plane);
    }
    effects_->begin_tick();
    ConesOfEffects cones(*effects_, god_.world());
    const FrictionSource source{cones, vec3(record.device_m).lpNorm<1>() +
                                           vec3(record.o_before_m).lpNorm<1>() +
                                           world_.anchor_scene_m.lpNorm<1>()};
    const ProxyState state = god_.move_with_friction(goal_m_, plane, source);
    EffectMotion motion;
    motion.dt_s = motion.longest_dt_s = kTick_s;
    motion.goal_m = goal_m_;
    effects_->evaluate_contact(god_.contact(), state, motion);
    effects_->end_tick();
    finish_effects();
    return state;
  }
  void finish_effects() {
    effects_->update_far_reach(god_.world(), god_.proxy(),
                               god_.radius_m() + 4 * god_.scale().stand_off_m);
  }
  void move_bodies(const std::optional<Vec3>& plane) {
    if (have_arrived_) return;
    std::size_t held = 0;
    if (is_placed_) {
      held = god_.move_bodies(motions_, plane);
    } else {
      for (const BodyMotion& m : motions_) god_.place_body(m.body, m.T_solver_body);
    }
    have_arrived_ = held == 0;
  }

  const ContactWorld& world_;
  bool is_planar_;
  GodObject god_;
  std::unique_ptr<EffectRunner> effects_;
  std::vector<BodyMotion> motions_;
  bool is_placed_ = false, have_arrived_ = true;
  Vec3 goal_m_ = Vec3::Zero();
};

// A body and a material.
using Name = std::pair<std::int32_t, std::int32_t>;

Name name_of(const Scene& scene, const FaceRef& face) {
  const std::uint32_t f = scene.world().bodies[face.body].index->face(face.slot);
  const auto m = scene.material(face.body, f);
  return {static_cast<std::int32_t>(face.body), m ? static_cast<std::int32_t>(*m) : -1};
}

// The names of the contacts that bear most; several if rounding decides between them. Empty: every
// contact may be named, because rounding decides whether the normals are independent.
std::vector<Name> bearers(const Scene& scene, const GodObject& god, const Vec3& lag_m) {
  using Long = long double;
  const auto contacts = god.contacts();
  const std::size_t count = contacts.size();
  std::vector<Name> names;
  for (const FaceContact& contact : contacts) names.push_back(name_of(scene, contact.face));
  if (count == 1) return names;
  Eigen::Matrix<Long, 3, 3> n;
  const Eigen::Matrix<Long, 3, 1> lag = lag_m.cast<Long>();
  n.col(0) = god.plane_normal(0).cast<Long>();
  n.col(1) = god.plane_normal(1).cast<Long>();
  const Eigen::Matrix<Long, 3, 1> across = n.col(0).cross(n.col(1));
  n.col(2) = count == 3 ? Eigen::Matrix<Long, 3, 1>(god.plane_normal(2).cast<Long>())
                        : Eigen::Matrix<Long, 3, 1>(across.normalized());
  const Long determinant = std::abs(across.dot(n.col(2)));
  constexpr Long kDependent = 1e-8L;  // bearing_parts: half the digits of double
  if (std::abs(determinant / kDependent - 1) < 0.5L) return {};
  if (!(determinant > kDependent)) return {*std::min_element(names.begin(), names.end())};
  std::array<Long, 3> parts{};  // Cramer's rule
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<int>(i);
    const Long part = lag.dot(n.col((k + 1) % 3).cross(n.col((k + 2) % 3))) /
                      n.col(0).cross(n.col(1)).dot(n.col(2));
    parts[i] = std::max<Long>(0, part);
  }
  // The inverse of a matrix of unit columns has a norm of at most 3 / determinant, and its double
  // has at most some tens of roundings of that size.
  const Long rounding = 0x1p-46L * lag.norm() / (determinant * determinant);
  const Long most = *std::max_element(parts.begin(), parts.begin() + static_cast<long>(count));
  std::vector<Name> best;
  for (std::size_t i = 0; i < count; ++i) {
    if (parts[i] >= most - rounding) best.push_back(names[i]);
  }
  return best;
}

struct Tally {
  std::uint64_t ticks = 0, touching = 0, decided_by_shares = 0, undecided = 0, began = 0, ended = 0,
                bad = 0, changed = 0, turned = 0;
  std::vector<bool> materials = std::vector<bool>(6), bodies = std::vector<bool>(16);
};

// A hand that moves from place to place through the boxes, and what disturbs it.
class TouchHand {
 public:
  explicit TouchHand(SeededRandom& random) : random_(random) {}

  Vec3 next_m() {
    if (left_ == 0) {
      left_ = 20 + static_cast<int>(random_.index(200));
      target_m_ = random_.in_box(0.045);
      speed_m_ = random_.uniform(2e-5, 1e-3);
    }
    --left_;
    const Vec3 way_m = target_m_ - p_m_;
    p_m_ += std::min(1.0, speed_m_ / std::max(way_m.norm(), 1e-9)) * way_m;
    return p_m_;
  }

 private:
  SeededRandom& random_;
  Vec3 p_m_ = Vec3(0.08, 0.0, 0.0), target_m_ = Vec3::Zero();
  double speed_m_ = 0.0;
  int left_ = 0;
};

class RandomTouches {
 public:
  RandomTouches(std::uint64_t seed, Tally& tally)
      : random_(seed),
        tally_(tally),
        radius_m_(random_.index(2) == 0 ? 0.0 : 0.003),
        hand_(random_) {}

  void run(int ticks) {
    const TouchScene touched = made_scene(random_, radius_m_);
    const int sensors = random_.index(3) == 0 ? 2 : 3;
    HapticSettings settings;
    settings.god_object.radius_m = radius_m_;
    settings.a4.enabled = random_.index(2) == 0;
    settings.initial_pose = {random_.rotation(), random_.in_box(0.01)};
    if (sensors == 2) settings.initial_pose.rotation.setIdentity();
    const ActuationModel actuation =
        *ActuationModel::from_counts(sensors, 1 + static_cast<int>(random_.index(2)));
    auto loop = test::made(HapticLoop::create(touched.scene.world(), actuation, settings));
    auto again = test::made(HapticLoop::create(touched.scene.world(), actuation, settings));
    Mirror mirror(touched, settings, sensors == 2);
    const bool has_moving_bodies = random_.index(2) == 0;
    for (int n = 0; n < ticks && !testing::Test::HasFatalFailure(); ++n) {
      if (has_moving_bodies && random_.index(10) == 0)
        move_a_body(touched.scene, loop, again, mirror);
      const bool is_refused = random_.index(150) == 0;
      const double dt_s = random_.index(200) == 0 ? -1.0 : kTick_s;
      Vec3 p_m = loop.T_device_scene().point(hand_.next_m());
      if (random_.index(200) == 0) p_m = random_.index(2) == 0 ? Vec3(p_m * NAN) : Vec3(p_m * 1e3);
      for (HapticLoop* each : {&loop, &again}) {
        if (is_refused) each->refuse_sample();
      }
      const TickRecord& record = loop.tick(p_m, dt_s);
      judge(touched.scene, mirror, record);
      const TickRecord& second = again.tick(p_m, dt_s);
      ASSERT_EQ(std::memcmp(&record, &second, sizeof record), 0);
    }
  }

 private:
  void move_a_body(const Scene& scene, HapticLoop& loop, HapticLoop& again, Mirror& mirror) {
    const auto body = static_cast<std::uint32_t>(random_.index(scene.objects().size()));
    RigidTransform T = scene.objects()[body].T_scene_body;
    T.translation_m += random_.in_box(0.004);
    loop.move_body(body, T);
    again.move_body(body, T);
    mirror.move_body(body, T);
  }

  void judge(const Scene& scene, Mirror& mirror, const TickRecord& record) {
    const ProxyState state = mirror.follow(record);
    const bool is_bad = (record.faults & kFaultsWithoutForce) != 0;
    const bool touches = record.contact == 1 && !is_bad;
    ++tally_.ticks;
    tally_.bad += is_bad;
    tally_.touching += touches;
    tally_.turned += record.rotation_rad != 0.0;
    // The rules of began and ended.
    ASSERT_EQ(record.touch, touches == touched_ ? 0
                            : touches           ? kTouchBegan
                                                : kTouchEnded)
        << record.tick;
    touched_ = touches;
    if (record.touch != 0) {
      ASSERT_EQ(record.touch, last_event_ == kTouchBegan ? kTouchEnded : kTouchBegan);
      last_event_ = record.touch;
    }
    tally_.began += record.touch == kTouchBegan;
    tally_.ended += record.touch == kTouchEnded;
    const Name name{record.body, record.material};
    if (!touches) {
      ASSERT_EQ(name, Name(kNothingTouched, kNothingTouched));
      ASSERT_EQ(record.contacts, 0);
      last_body_ = kNothingTouched;
      return;
    }
    ASSERT_TRUE(state.in_contact);
    ASSERT_EQ(scene.world().to_scene(state.proxy), vec3(record.proxy_scene_m)) << "mirror";
    ASSERT_EQ(record.contacts, mirror.god().contacts().size());
    if (record.contacts == 0) {
      ASSERT_EQ(name, Name(kNothingTouched, kNothingTouched));
      return;
    }
    const std::vector<Name> best = bearers(scene, mirror.god(), mirror.lag_m());
    const bool is_decided =
        std::adjacent_find(best.begin(), best.end(), std::not_equal_to<>()) == best.end() &&
        !best.empty();
    tally_.undecided += !is_decided;
    if (!best.empty()) {
      ASSERT_NE(std::find(best.begin(), best.end(), name), best.end())
          << "tick " << record.tick << ": body " << name.first << ", material " << name.second
          << " in place of " << best[0].first << ", " << best[0].second;
    }
    for (const FaceContact& contact : mirror.god().contacts()) {
      if (name_of(scene, contact.face) == name) continue;
      ++tally_.decided_by_shares;
      break;
    }
    tally_.changed += last_body_ != kNothingTouched && last_body_ != record.body;
    last_body_ = record.body;
    tally_.bodies[static_cast<std::size_t>(record.body)] = true;
    tally_.materials[static_cast<std::size_t>(record.material + 1)] = true;
    ASSERT_EQ(scene.body_name(record.body), "box " + std::to_string(record.body));
    ASSERT_EQ(scene.material_name(record.material),
              record.material < 0 ? "" : "material " + std::to_string(record.material));
  }

  SeededRandom random_;
  Tally& tally_;
  double radius_m_;
  TouchHand hand_;
  bool touched_ = false;
  std::uint16_t last_event_ = kTouchEnded;
  std::int32_t last_body_ = kNothingTouched;
};

TEST(Touch, NamesTheContactThatBearsMostInRandomScenes) {
  const int ticks = test::in_soak_or_else(1'000'000, 60'000);
  constexpr int kTicksPerScene = 2000;
  Random random(4711);
  Tally tally;
  for (int n = 0; n < ticks && !HasFatalFailure(); n += kTicksPerScene) {
    const std::uint64_t seed = random.index(~std::uint64_t{0});
    SCOPED_TRACE("seed of the scene " + std::to_string(seed));
    RandomTouches(seed, tally).run(kTicksPerScene);
  }
  const auto share = [&](std::uint64_t count, double least) {
    EXPECT_GT(static_cast<double>(count), least * static_cast<double>(tally.ticks));
  };
  share(tally.touching, 0.2);
  share(tally.decided_by_shares, 0.005);
  share(tally.began, 0.005);
  share(tally.ended, 0.005);
  share(tally.changed, 0.0005);
  share(tally.bad, 0.005);
  share(tally.turned, 0.02);
  EXPECT_LT(tally.undecided, tally.touching / 200);
  EXPECT_EQ(std::count(tally.materials.begin(), tally.materials.end(), true), 6);
  EXPECT_GE(std::count(tally.bodies.begin(), tally.bodies.end(), true), 10);
  RecordProperty("touching", static_cast<int>(tally.touching));
  RecordProperty("decided_by_shares", static_cast<int>(tally.decided_by_shares));
  RecordProperty("undecided", static_cast<int>(tally.undecided));
  RecordProperty("changed", static_cast<int>(tally.changed));
}

// Contacts with given faces and normals, in a world of four bodies. Each has two triangles, which
// have two materials in the last body.
class GivenContacts : public testing::Test {
 protected:
  GivenContacts() {
    test::Soup soup;
    soup.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    soup.add({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    owned_.emplace(soup);
    world_ = owned_->world();
    auto materials = std::make_shared<FaceMaterials>();
    for (const std::int32_t m : {7, 5, -1}) {
      materials->add_body(materials->add_surface({{0, m}}));
    }
    materials->add_body(materials->add_surface({{0, 3}, {1, 4}}));
    world_.bodies.assign(4, world_.bodies[0]);
    world_.materials = materials;
    live_.emplace(world_);
  }

  // bodies: of the contacts, whose normals are A1, A2 and A3.
  TickRecord named(const std::vector<std::uint32_t>& bodies, const Vec3& lag_m,
                   const std::array<std::uint32_t, 3>& slots = {}) {
    std::vector<FaceContact> contacts;
    std::vector<ContactPlane> planes;
    std::array<int, 3> plane_of_contact{};
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Vec3 normal = Vec3::Unit(static_cast<int>(i));
      contacts.push_back(
          {{bodies[i], slots[i]}, normal, 0.0, TriangleFeature::kFace, Vec3::Zero()});
      planes.push_back({normal, 0.0});
      plane_of_contact[i] = static_cast<int>(i);
    }
    TickRecord record;
    record.body = record.material = 99;
    TouchState(world_).name_largest(ContactView(*live_, contacts, planes, plane_of_contact), lag_m,
                                    record);
    return record;
  }

  std::optional<test::OwnedWorld> owned_;
  ContactWorld world_;
  std::optional<LiveWorld> live_;
};

TEST_F(GivenContacts, TheLargestShareNamesBodyAndMaterial) {
  EXPECT_EQ(named({0, 1}, {2, 3, 0}).body, 1);
  EXPECT_EQ(named({0, 1}, {2, 3, 0}).material, 5);
  EXPECT_EQ(named({0, 1}, {3, 2, 0}).body, 0);
  EXPECT_EQ(named({0, 1}, {3, 2, 0}).material, 7);
  EXPECT_EQ(named({0, 1, 2}, {1, 2, 3}).body, 2);
  EXPECT_EQ(named({0, 1, 2}, {1, 2, 3}).material, kNothingTouched);
  EXPECT_EQ(named({0, 1, 2}, {1, 2, 3}).contacts, 3);
  EXPECT_EQ(named({0, 1}, {-9, 1, 0}).body, 1) << "a normal bears no pull";
}

TEST_F(GivenContacts, OfOneBodyTheLargestShareNamesTheMaterial) {
  const auto material_of = [&](std::uint32_t slot) {
    return owned_->index().face(slot) == 0 ? 3 : 4;
  };
  ASSERT_NE(material_of(0), material_of(1));
  EXPECT_EQ(named({3, 3}, {3, 2, 0}, {0, 1}).material, material_of(0));
  EXPECT_EQ(named({3, 3}, {2, 3, 0}, {0, 1}).material, material_of(1));
  EXPECT_EQ(named({3, 3}, {2, 3, 0}, {1, 0}).material, material_of(0));
  EXPECT_EQ(named({3, 3}, {2, 2, 0}, {0, 1}).material, 3) << "the lowest of equal shares";
}

TEST_F(GivenContacts, OfEqualSharesTheLowestBodyCounts) {
  EXPECT_EQ(named({1, 0}, {2, 2, 0}).body, 0);
  EXPECT_EQ(named({0, 1}, {2, 2, 0}).body, 0);
  EXPECT_EQ(named({2, 1, 0}, {2, 2, 2}).body, 0);
  EXPECT_EQ(named({2, 1, 0}, {2, 2, 1}).body, 1);
}

TEST_F(GivenContacts, ATickWithoutContactsNamesNothing) {
  const TickRecord record = named({}, {1, 0, 0});
  EXPECT_EQ(record.body, kNothingTouched);
  EXPECT_EQ(record.material, kNothingTouched);
  EXPECT_EQ(record.contacts, 0);
}

TEST_F(GivenContacts, AWorldWithoutMaterialsNamesTheBodyAlone) {
  world_.materials = nullptr;
  const TickRecord record = named({1, 0}, {1, 0, 0});
  EXPECT_EQ(record.body, 1);
  EXPECT_EQ(record.material, kNothingTouched);
}

// The hand above, in and above a plate.
class PressedPlate : public testing::Test {
 protected:
  PressedPlate()
      : world_(test::box_soup({0.05, 0.05, 0.01})),
        loop_(test::made(
            HapticLoop::create(world_.world(), *ActuationModel::from_counts(3, 3), {}))) {}
  const TickRecord& tick(double z_m, double dt_s = kTick_s) {
    return loop_.tick({0, 0, z_m}, dt_s);
  }

  test::OwnedWorld world_;
  HapticLoop loop_;
};

TEST_F(PressedPlate, ABadSampleEndsATouchAndTheNextGoodTickBeginsIt) {
  EXPECT_EQ(tick(0.011).touch, 0);
  EXPECT_EQ(tick(0.009).touch, kTouchBegan);
  EXPECT_EQ(tick(0.008).touch, 0);
  const TickRecord bad = tick(NAN);
  EXPECT_EQ(bad.contact, 1) << "the state of the tick before";
  EXPECT_EQ(bad.touch, kTouchEnded);
  EXPECT_EQ(bad.body, kNothingTouched);
  EXPECT_EQ(tick(0.008, -1.0).touch, 0);
  const TickRecord good = tick(0.008);
  EXPECT_EQ(good.touch, kTouchBegan);
  EXPECT_EQ(good.body, 0);
  EXPECT_EQ(tick(0.012).touch, kTouchEnded);
  EXPECT_EQ(tick(0.012).touch, 0);
}

TEST_F(PressedPlate, AHandThatIsFreedTouchesNothing) {
  tick(0.011);
  EXPECT_EQ(tick(0.009).touch, kTouchBegan);
  loop_.free_hand();
  EXPECT_EQ(tick(0.009).touch, kTouchEnded);
  EXPECT_EQ(tick(0.009).touch, 0);
}

}  // namespace
}  // namespace palpate
