// The haptic thread neither allocates nor locks: counted, not claimed. This executable replaces
// operator new and delete, and, where no sanitizer has done so already, malloc and its family and
// the pthread locks, for every library it loads: Embree, its TBB and the C++ runtime too.

#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <dlfcn.h>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <pthread.h>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "engine/devices/vector_device.h"
#include "engine/live/led_hand.h"
#include "engine/live/pointed_device.h"
#include "engine/live/start_place.h"
#include "engine/live/trial_watch.h"
#include "engine/recording/recorder.h"
#include "engine/recording/recording_settings.h"
#include "engine/scene/scene.h"
#include "engine/session/haptic_session.h"
#include "engine/session/haptic_thread.h"
#include "engine/session/node_motions.h"
#include "engine/session/run_summary.h"
#include "engine/simulation/contour_path.h"
#include "engine/simulation/path_plan.h"
#include "engine/simulation/simulated_device.h"
#include "engine/simulation/surface_path.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/paper_plan.h"
#include "engine/trials/plan.h"
#include "engine/viewer/held_device.h"
#include "engine/viewer/pointer_plan.h"
#include "engine/viewer/state_publisher.h"
#include "geometry/mesh/section.h"
#include "haptics/record_vectors.h"
#include "tests/helpers/all_effects.h"
#include "tests/helpers/gltf_builder.h"
#include "tests/helpers/made.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PALPATE_TEST_IS_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PALPATE_TEST_IS_SANITIZED 1
#endif
#endif

namespace {

std::atomic<bool> g_counting{false};
std::atomic<std::uint64_t> g_allocations{0};
std::atomic<std::uint64_t> g_releases{0};
std::atomic<std::uint64_t> g_locks{0};

std::atomic<bool> g_counts_one_thread{false};
thread_local bool t_is_counted = false;  // where only one thread is

void count(std::atomic<std::uint64_t>& counter) noexcept {
  if (!g_counting.load(std::memory_order_relaxed)) return;
  if (g_counts_one_thread.load(std::memory_order_relaxed) && !t_is_counted) return;
  counter.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

#ifndef PALPATE_TEST_IS_SANITIZED

extern "C" {

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  count(g_allocations);
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count(g_allocations);
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  count(g_allocations);
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count(g_allocations);
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) {
  *p = memalign(alignment, size);
  return *p || size == 0 ? 0 : ENOMEM;
}
void free(void* p) {
  if (p) count(g_releases);
  __libc_free(p);
}

// The C library looks a lock up once, before anything is counted.
int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  using Function = int (*)(pthread_mutex_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_mutex_lock"));
  count(g_locks);
  return real(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  using Function = int (*)(pthread_mutex_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_mutex_trylock"));
  count(g_locks);
  return real(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  using Function = int (*)(pthread_rwlock_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_rwlock_rdlock"));
  count(g_locks);
  return real(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  using Function = int (*)(pthread_rwlock_t*);
  static const auto real = reinterpret_cast<Function>(dlsym(RTLD_NEXT, "pthread_rwlock_wrlock"));
  count(g_locks);
  return real(lock);
}

}  // extern "C"

#endif  // PALPATE_TEST_IS_SANITIZED

// Without a sanitizer these count twice, here and in malloc(): what is asked is whether any came.
void* operator new(std::size_t size) {
  count(g_allocations);
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  count(g_allocations);
  return std::malloc(size ? size : 1);
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  count(g_allocations);
  void* p = nullptr;
  if (posix_memalign(&p, static_cast<std::size_t>(alignment), size ? size : 1) == 0) return p;
  throw std::bad_alloc();
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return operator new(size, alignment);
}
void operator delete(void* p) noexcept {
  if (p) count(g_releases);
  std::free(p);
}
void operator delete[](void* p) noexcept {
  operator delete(p);
}
void operator delete(void* p, std::size_t) noexcept {
  operator delete(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  operator delete(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  operator delete(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
  operator delete(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  operator delete(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  operator delete(p);
}

namespace palpate {
namespace {

using test::Random;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Counts on all threads between its construction and stop().
class Census {
 public:
  Census() {
    g_allocations = 0;
    g_releases = 0;
    g_locks = 0;
    g_counting = true;
  }
  ~Census() { stop(); }
  void stop() { g_counting = false; }

  std::uint64_t allocations() const { return g_allocations; }
  std::uint64_t releases() const { return g_releases; }
  std::uint64_t locks() const { return g_locks; }
  void expect_nothing() const {
    EXPECT_EQ(allocations(), 0u);
    EXPECT_EQ(releases(), 0u);
    EXPECT_EQ(locks(), 0u);
  }
};

// Counts on the thread that constructs it only.
class ThreadCensus : public Census {
 public:
  ThreadCensus() {
    t_is_counted = true;
    g_counts_one_thread = true;
  }
  ~ThreadCensus() {
    g_counts_one_thread = false;
    t_is_counted = false;
  }
};

// Keeps the optimiser from leaving an unused allocation out.
void keep(void* p) {
  asm volatile("" : : "g"(p) : "memory");
}

// ---- the counter itself ------------------------------------------------------------------------

TEST(Census, SeesAllocationsByOperatorNew) {
  struct alignas(64) Wide {
    double numbers[8];
  };
  const auto expect_seen = [](auto action) {
    Census census;
    action();
    census.stop();
    EXPECT_GT(census.allocations(), 0u);
    EXPECT_GT(census.releases(), 0u);
  };
  expect_seen([] { keep(std::make_unique<int>(1).get()); });
  expect_seen([] { keep(std::make_unique<Wide>().get()); });
  expect_seen([] { keep(std::vector<double>(100).data()); });
  expect_seen([] { keep(std::string(100, 'x').data()); });
}

#ifndef PALPATE_TEST_IS_SANITIZED

TEST(Census, SeesAllocationsByMalloc) {
  const auto expect_seen = [](auto action) {
    Census census;
    action();
    census.stop();
    EXPECT_EQ(census.allocations(), 1u);
  };
  expect_seen([] {
    void* p = std::malloc(10);
    keep(p);
    std::free(p);
  });
  expect_seen([] {
    void* p = std::calloc(10, 10);
    keep(p);
    std::free(p);
  });
  expect_seen([] {
    void* p = nullptr;
    if (posix_memalign(&p, 64, 64) == 0) keep(p);
    std::free(p);
  });
  Eigen::VectorXd vector;
  Census census;
  vector.resize(100);  // Eigen's own allocation
  census.stop();
  EXPECT_GT(census.allocations(), 0u);
}

TEST(Census, SeesLocks) {
  std::mutex mutex;
  Census census;
  mutex.lock();
  census.stop();
  mutex.unlock();
  EXPECT_EQ(census.locks(), 1u);
}

// Embree allocates and locks while it builds: seen through the library's own calls.
TEST(Census, SeesIntoEmbree) {
  const SurfaceMesh mesh = SurfaceMesh::build({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  Census census;
  const SurfaceIndex index(mesh);
  census.stop();
  EXPECT_GT(census.allocations(), 0u);
  EXPECT_GT(census.locks(), 0u);
}

#endif

// ---- ticks -------------------------------------------------------------------------------------

// Every stage of a touch with a scene around the origin.
std::vector<Vec3> eventful_path(const Vec3& extent_m, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> path;
  const auto inside = [&](double share) {
    return Vec3(share * random.in_box(0.5).cwiseProduct(extent_m));
  };
  Vec3 p = 2.0 * extent_m;
  for (int stage = 0; stage < 60; ++stage) {
    const Vec3 there = inside(1.4);
    switch (random.index(4)) {
      case 0:  // through, past, along: whatever lies on the way
        for (int i = 0; i < 60; ++i) path.push_back(p + (i / 60.0) * (there - p));
        break;
      case 1:  // trembling at one place
        for (int i = 0; i < 60; ++i) path.push_back(there + inside(1e-2));
        break;
      case 2:  // teleports
        for (int i = 0; i < 30; ++i) path.push_back(inside(2.0));
        break;
      default:  // bad samples among good ones
        for (int i = 0; i < 10; ++i) {
          path.push_back(inside(1.0));
          path.emplace_back(kNan, 0.0, 0.0);
          path.emplace_back(0.0, i % 2 ? kInfinity : -kInfinity, 1e200);
        }
    }
    p = there;
  }
  return path;
}

class PlayedDevice final : public VectorDevice {
 public:
  explicit PlayedDevice(const std::vector<Vec3>& path) : path_(path) {}
  Vec3 read_position_m(double) noexcept override { return path_[n_++ % path_.size()]; }
  void command_force_N(const Vec3& force) noexcept override { last_force_N_ = force; }

 private:
  const std::vector<Vec3>& path_;
  std::size_t n_ = 0;
  Vec3 last_force_N_ = Vec3::Zero();
};

class SummingObserver final : public TickObserver {
 public:
  void on_tick(const TickRecord& record) noexcept override {
    sums.add(record);
    turned = turned || pose_before(record).rotation.coeffs() != Quat::Identity().coeffs();
  }
  SummaryAccumulator sums;
  bool turned = false;
};

struct Stage {
  const char* model;
  int sensors;
  int actuators;
  double radius_m;
  ForceMode force;
  Table1Form table1 = Table1Form::kCorrected;
  const char* strategy = nullptr;  // in place of the force and A4
};

void PrintTo(const Stage& s, std::ostream* out) {
  *out << s.model << " with " << s.sensors << " sensors, " << s.actuators
       << " actuators, proxy radius " << s.radius_m << " m"
       << (s.table1 == Table1Form::kAsPrinted ? ", Table 1 as printed" : "")
       << (s.strategy ? s.strategy : "");
}

class SilentTick : public testing::TestWithParam<Stage> {};

TEST_P(SilentTick, NeitherAllocatesNorLocksAtAnyStageOfATouch) {
  const Stage& stage = GetParam();
  const auto scene = Scene::load(std::string(PALPATE_MODELS_DIR "/") + stage.model,
                                 {.proxy_radius_m = stage.radius_m});
  ASSERT_TRUE(scene) << scene.error().to_string();
  HapticSettings settings;
  settings.god_object.radius_m = stage.radius_m;
  settings.force = stage.force;
  settings.a4.table1 = stage.table1;
  if (stage.strategy) set_strategy(*parse_strategy(stage.strategy), settings);
  if (stage.radius_m > 0.0) settings.coupling.velocity = {VelocityMethod::kAdaptive, 63, 2e-5};
  const std::vector<Vec3> path = eventful_path(scene->statistics().extent_m, 1);
  auto loop = test::made(HapticLoop::create(
      scene->world(), *ActuationModel::from_counts(stage.sensors, stage.actuators), settings));
  PlayedDevice device(path);
  SummingObserver observer;
  HapticSession session(loop, device, {.observers = {&observer}});
  session.start();
  TickRecord snapshot;
  Census census;
  for (int n = 0; n < 4000; ++n) {
    session.tick(n % 500 == 499 ? kNan : n % 500 == 498 ? 0.0 : 1e-3);
    session.latest(snapshot);
  }
  census.stop();
  census.expect_nothing();
  // The path did lead through everything.
  const RunSummary s = observer.sums.finish({});
  EXPECT_GT(s.contact_ticks, 500u);
  EXPECT_GT(s.losses_of_contact, 5u);
  EXPECT_GT(s.faults[0], 50u);
  EXPECT_EQ(s.faults[1], 16u);
  EXPECT_EQ(observer.turned,
            settings.a4.enabled && 0 < stage.actuators && stage.actuators < stage.sensors);
}

INSTANTIATE_TEST_SUITE_P(AllStages, SilentTick,
                         testing::Values(Stage{"star.glb", 2, 1, 0.0, ForceMode::kActuated},
                                         Stage{"star.glb", 2, 1, 4e-3, ForceMode::kFull},
                                         Stage{"labyrinth.glb", 2, 0, 0.0, ForceMode::kNone},
                                         Stage{"lock.glb", 2, 2, 4e-3, ForceMode::kActuated},
                                         Stage{"torus.glb", 3, 1, 0.0, ForceMode::kActuated},
                                         Stage{"torus.glb", 3, 2, 0.02, ForceMode::kFull},
                                         Stage{"torus.glb", 3, 1, 0.0, ForceMode::kFull,
                                               Table1Form::kAsPrinted},
                                         Stage{"sphere.glb", 3, 2, 0.0, ForceMode::kActuated},
                                         Stage{"sphere.glb", 3, 3, 0.05, ForceMode::kActuated},
                                         Stage{"cube.glb", 3, 3, 0.0, ForceMode::kFull},
                                         Stage{"thin_plate.glb", 3, 1, 1e-3, ForceMode::kActuated},
                                         Stage{"torus.glb", 3, 1, 0.02, {}, {}, "a4-anticipate"},
                                         Stage{"star.glb", 2, 1, 0.0, {}, {}, "a4-anticipate"},
                                         Stage{"torus.glb", 3, 1, 0.02, {}, {}, "a4-passive:1"},
                                         Stage{"star.glb", 2, 1, 0.0, {}, {}, "a4-passive"},
                                         Stage{"torus.glb", 3, 1, 0.0, {}, {}, "anisotropic:0.25"},
                                         Stage{"star.glb", 2, 1, 0.0, {}, {}, "anisotropic:4"},
                                         Stage{"torus.glb", 3, 2, 0.02, {}, {}, "cd"},
                                         Stage{"star.glb", 2, 1, 0.0, {}, {}, "cd"}));

// ---- the simulated hand runs on the same thread ------------------------------------------------

void expect_silent_hand(const Scene& scene, HandPlan& plan, const Vec3& start_m, int sensors) {
  auto loop =
      test::made(HapticLoop::create(scene.world(), *ActuationModel::from_counts(sensors, 1), {}));
  SimulatedDevice device({}, plan, start_m, {}, sensors == 2);
  HapticSession session(loop, device, {.observers = {&device}});
  session.start();
  Census census;
  std::uint64_t contact_ticks = 0;
  TickRecord snapshot;
  for (int n = 0; n < 28000; ++n) {
    session.tick(1e-3);
    if (session.latest(snapshot)) contact_ticks += snapshot.contact;
  }
  census.stop();
  census.expect_nothing();
  EXPECT_GT(contact_ticks, 14000u);
}

TEST(SilentHand, FollowsAContourWithoutAllocating) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/star.glb");
  ASSERT_TRUE(scene);
  std::vector<Vec3> positions;
  std::vector<Triangle> triangles;
  scene->append_triangles_scene(positions, triangles);
  const auto section = plane_section(positions, triangles, Vec3::UnitZ(), 0.0);
  ASSERT_FALSE(section.empty());
  PathFacts facts;
  facts.room_m = 8e-3;
  const auto contour = open_contour(section.front(), section, Vec3::UnitZ(), facts.room_m);
  PathPlan plan(contour_path(contour, Vec3::UnitZ(), 1e-3), facts, {});
  expect_silent_hand(*scene, plan, plan.start_scene_m(), 2);
}

TEST(SilentHand, WalksOverASurfaceWithoutAllocating) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/torus.glb");
  ASSERT_TRUE(scene);
  const auto found = plan_surface_path(*scene, {});
  ASSERT_TRUE(found);
  PathFacts facts;
  facts.room_m = 8e-3;
  facts.may_cross_itself = true;
  PathPlan plan(simplified(found->path, 1e-3), facts, {});
  expect_silent_hand(*scene, plan, plan.start_scene_m(), 3);
}

// ---- many bodies, some of which move -----------------------------------------------------------

TEST(SilentBodies, AreFoundAndMovedWithoutAllocating) {
  SceneDescription description;
  test::Soup box = test::box_soup(Vec3::Constant(0.01));
  description.meshes = {{"box", std::move(box.positions), std::move(box.triangles)}};
  test::Random random(4);
  for (int b = 0; b < 400; ++b) {
    const Mat3 turn = random.rotation().toRotationMatrix();
    description.nodes.push_back({"box " + std::to_string(b), 0, turn, random.in_box(0.1)});
  }
  const auto scene = Scene::compile(std::move(description));
  ASSERT_TRUE(scene);
  NodeMotions motions(*scene);
  std::vector<std::size_t> handles;
  for (int b = 0; b < 400; b += 40) handles.push_back(*motions.add("box " + std::to_string(b)));
  const std::vector<Vec3> path = eventful_path(scene->statistics().extent_m, 3);
  auto loop =
      test::made(HapticLoop::create(scene->world(), *ActuationModel::from_counts(3, 1), {}));
  PlayedDevice device(path);
  SummingObserver observer;
  HapticSession session(loop, device, {.changes = {&motions}, .observers = {&observer}});
  session.start();
  Census census;
  for (int n = 0; n < 4000; ++n) {
    for (const std::size_t handle : handles) {
      motions.set(handle, {Quat::Identity(), Vec3(0, 0, 0.05 * std::sin(2e-3 * n))});
    }
    session.tick(1e-3);
  }
  census.stop();
  census.expect_nothing();
  EXPECT_GT(observer.sums.finish({}).contact_ticks, 300u);
}

// A box whose sides are nodes: a point is judged on the corners that they share.
TEST(SilentBodies, AreJudgedWhereTheyMeetWithoutAllocating) {
  SceneDescription description;
  test::Soup side;
  side.add_quad({-0.1, -0.1, 0.1}, {0.1, -0.1, 0.1}, {0.1, 0.1, 0.1}, {-0.1, 0.1, 0.1});
  description.meshes = {{"side", std::move(side.positions), std::move(side.triangles)}};
  const Mat3 turn = test::Random(6).rotation().toRotationMatrix();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double to : {-1.0, 1.0}) {
      Mat3 linear = Mat3::Zero();
      linear((axis + 1) % 3, 0) = linear((axis + 2) % 3, 1) = 1.0;
      linear(axis, 2) = to;
      description.nodes.push_back({"side", 0, turn * linear, Vec3::Zero()});
    }
  }
  const auto scene = Scene::compile(std::move(description));
  ASSERT_TRUE(scene);
  ASSERT_EQ(scene->statistics().seam_places, 8u);
  const std::vector<Vec3> path = eventful_path(scene->statistics().extent_m, 3);
  auto loop =
      test::made(HapticLoop::create(scene->world(), *ActuationModel::from_counts(3, 1), {}));
  PlayedDevice device(path);
  SummingObserver observer;
  HapticSession session(loop, device, {.observers = {&observer}});
  session.start();
  Census census;
  for (int n = 0; n < 4000; ++n) session.tick(1e-3);
  census.stop();
  census.expect_nothing();
  EXPECT_GT(observer.sums.finish({}).contact_ticks, 300u);
}

// ---- all effects -------------------------------------------------------------------------------

TEST(SilentEffects, AreFeltCountedAndTunedWithoutAllocating) {
  test::Random random(5);
  test::BodyHand hand({test::AllEffects::sphere(), test::AllEffects::plate()}, random.pose(0.1));
  test::AllEffects::add_to(hand);
  HapticSettings settings = test::hand_settings();
  settings.a4.enabled = true;
  settings.measures_effects = true;
  hand.begin(settings, 1);
  const auto& calls = hand.world().effects->calls;
  test::Wander wander(random, 0.044, 0.08);
  const std::vector<std::byte>& parameters = hand.world().effects->parameters;
  Census census;
  std::uint32_t active_effects = 0;
  for (int n = 0; n < 10000; ++n) {
    const Vec3 p = n % 500 == 7 ? Vec3(kNan, 0, 0) : wander.next();
    if (n % 100 == 50) hand.loop().move_body(0, hand.pose());
    const auto call = static_cast<std::uint32_t>(static_cast<std::size_t>(n) % calls.size());
    hand.loop().set_effect_parameters(
        call, std::span(parameters)
                  .subspan(calls[call].parameters,
                           compiled_effects()[calls[call].effect].parameter_bytes));
    active_effects |= hand.go_to(p, n % 700 == 9 ? -1.0 : 1e-3).effects;
  }
  census.stop();
  census.expect_nothing();
  EXPECT_EQ(active_effects, (1u << compiled_effects().size()) - 1) << "see AllEffects";
}

// ---- a session that a page watches and changes -------------------------------------------------

TEST(SilentView, PublishesTicksAndTakesChangesWithoutAllocating) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/gallery.glb");
  ASSERT_TRUE(scene);
  RunSettings settings;
  settings.sensors = 3;
  settings.actuators = 2;
  settings.moves = {{scene->objects()[1].name, Vec3(0.0, 0.0, 0.01), Vec3::Zero()}};
  const RunSetup setup = *make_setup(settings);
  auto mover = SteadyMotions::create(*scene, setup.moves);
  ASSERT_TRUE(mover);
  const Vec3 middle =
      0.5 * (scene->statistics().bounds_scene.low + scene->statistics().bounds_scene.high);
  PointerPlan plan(middle);
  SimulatedDevice simulated({}, plan, middle, {}, false);
  LiveSettings live(*scene, setup);
  HeldDevice held(simulated, live);
  auto loop = test::made(HapticLoop::create(scene->world(), setup.actuation, setup.haptics));
  StatePublisher publisher(loop, &plan, scene->objects().size());
  HapticSession session(
      loop, held,
      {.changes = {&*mover, &live}, .observers = {&publisher, &simulated}, .takes_motors = false});
  session.start();
  test::Random random(3);
  std::uint64_t contacts = 0;
  TickRecord newest;
  for (std::uint64_t n = 1; n < 5000; ++n) {
    const Vec3 target = middle + random.in_box(0.1);
    if (n % 20 == 0) plan.point({n % 300 != 0, n, {target.x(), target.y(), target.z()}});
    if (n % 50 == 0) live.set(live_setting("a4"), n % 100 == 0 ? 1.0 : 0.0);
    if (n % 70 == 0) live.set_axes({random.unit_vector()});
    if (n % 900 == 0) plan.start();
    session.set_paused(n % 400 < 10);
    Census census;
    session.tick(1e-3);
    census.stop();
    census.expect_nothing();
    if (session.latest(newest)) contacts += newest.contact;
  }
  EXPECT_GT(contacts, 500u);
}

// ---- a trial of a person -----------------------------------------------------------------------

class SilentTrial : public ::testing::Test {
 protected:
  Result<ExperimentPlan> plan =
      parse_plan(shipped_plan_text("paper-live-mouse", ""), "plan", PALPATE_MODELS_DIR);
  std::vector<ExperimentScene> scenes =
      test::made(load_experiment_scenes(plan.value(), {find_trial_way, run_trial}));
  const ExperimentScene& scene = scenes.front();
};

TEST_F(SilentTrial, FollowsThePointerAndFindsWhoIsLostWithoutAllocating) {
  RunSetup setup = scene.setup;
  setup.haptics.a4.enabled = true;
  const auto start_m = start_place_m(scene.scene, scene.way, plan->trial.sphere_radius_m);
  ASSERT_TRUE(start_m);
  PointedDevice pointer(setup.device, setup.haptics.initial_pose.point(*start_m), true);
  auto loop = test::made(HapticLoop::create(scene.scene.world(), setup.actuation, setup.haptics));
  TrialClock clock(scene.way, plan->trial, 0.0, 1e-3);
  TrialWatch watch(&clock, 1e-3, 1.0, &pointer.clutch());
  StatePublisher publisher(loop, &pointer, 0);
  HapticSession session(
      loop, pointer, {.observers = {&pointer, &clock, &watch, &publisher}, .takes_motors = false});
  session.start();
  test::Random random(4);
  for (std::uint64_t n = 1; n < 4000; ++n) {
    // Through the green sphere into the wall, and after a second away from it.
    const Vec3 target = setup.haptics.initial_pose.point(scene.way.green_m) +
                        random.in_box(n < 1000 ? 0.005 : 0.0) + Vec3(n < 1000 ? 0.0 : 1.0, 0, 0);
    pointer.point({n % 100 != 0, n, {target.x(), target.y(), target.z()}, n % 50 < 10});
    Census census;
    session.tick(1e-3);
    census.stop();
    census.expect_nothing();
  }
  EXPECT_TRUE(clock.has_started());
  EXPECT_EQ(watch.times_lost(), 1u);
}

// A hand that the pointer leads, at a wall that pushes it back.
TEST_F(SilentTrial, LeadsAHandWithoutAllocating) {
  RunSetup setup = scene.setup;
  setup.haptics.force = ForceMode::kFull;
  const Vec3 green_m = setup.haptics.initial_pose.point(scene.way.green_m);
  PointedDevice pointer(setup.device, green_m);
  LedHand hand(pointer, setup, {}, green_m);
  auto loop = test::made(HapticLoop::create(scene.scene.world(), setup.actuation, setup.haptics));
  StatePublisher publisher(loop, &pointer, 0);
  HapticSession session(loop, hand.device(), {.observers = {&publisher}, .takes_motors = false});
  session.start();
  test::Random random(5);
  std::uint64_t contacts = 0;
  TickRecord newest;
  for (std::uint64_t n = 1; n < 4000; ++n) {
    const Vec3 target = green_m + random.in_box(0.02);
    if (n % 20 == 0) pointer.point({n % 100 != 0, n, {target.x(), target.y(), target.z()}});
    Census census;
    session.tick(1e-3);
    census.stop();
    census.expect_nothing();
    if (session.latest(newest)) contacts += newest.contact;
  }
  EXPECT_GT(contacts, 500u);
}

// ---- the thread --------------------------------------------------------------------------------

TEST(SilentThread, NeitherAllocatesNorLocksOnceItHasStarted) {
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/torus.glb");
  ASSERT_TRUE(scene);
  const std::vector<Vec3> path = eventful_path(scene->statistics().extent_m, 2);
  auto loop =
      test::made(HapticLoop::create(scene->world(), *ActuationModel::from_counts(3, 1), {}));
  PlayedDevice device(path);
  SummingObserver observer;
  HapticSession session(loop, device, {.observers = {&observer}});
  HapticThread thread(session, {5000.0, 0});
  thread.start();
  Census census;  // from the first tick on, or nearly
  TickRecord snapshot;
  while (thread.ticks() < 2000) {
    session.latest(snapshot);
    std::this_thread::yield();
  }
  census.stop();
  thread.stop();
  census.expect_nothing();
  EXPECT_GT(observer.sums.finish({}).contact_ticks, 100u);
}

// ---- a recording -------------------------------------------------------------------------------

// The thread of the ticks hands over rows, inputs and events; the thread of the recorder allocates.
TEST(SilentRecording, NeitherAllocatesNorLocksInATick) {
  const test::TemporaryFolder folder;
  const auto scene = Scene::load(PALPATE_MODELS_DIR "/torus.glb");
  ASSERT_TRUE(scene);
  RecordedSetup setup;
  setup.scene_path = PALPATE_MODELS_DIR "/torus.glb";
  const auto meta = meta_of(*scene, setup);
  ASSERT_TRUE(meta);
  auto recorder = Recorder::create(folder.path("a.palpate"), *meta, {});
  ASSERT_TRUE(recorder);
  const std::vector<Vec3> path = eventful_path(scene->statistics().extent_m, 2);
  auto loop = test::made(HapticLoop::create(scene->world(), setup.actuation, setup.haptics));
  PlayedDevice device(path);
  auto mover = SteadyMotions::create(
      *scene, {{scene->tree().front().name, Vec3(1e-4, 0, 0), Vec3(0, 0, 1e-3)}});
  ASSERT_TRUE(mover);
  HapticSession session(loop, device, {.changes = {&*mover}, .sink = recorder->get()});
  ASSERT_FALSE(session.start());
  ThreadCensus census;
  for (int n = 0; n < 5'000; ++n) session.tick(1e-3);
  session.report_late(LateCause::kOurs, {});
  census.stop();
  session.stop();
  census.expect_nothing();
  const RecordingResult result = (*recorder)->finish("end");
  EXPECT_FALSE(result.error);
  EXPECT_EQ(result.ticks, 5'000u);
}

}  // namespace
}  // namespace palpate
