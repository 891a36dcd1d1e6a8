#include "engine/session/work_price.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "engine/devices/monotonic_clock.h"
#include "geometry/base/random.h"
#include "geometry/index/surface_index.h"
#include "geometry/mesh/surface_mesh.h"
#include "haptics/proxy/god_object.h"

namespace palpate {
namespace {

// Every input is measured this often, and the shortest time counts: it is the one without
// interruptions.
constexpr int kRounds = 5;
constexpr int kTicks = 8;
constexpr std::size_t kTriangles = 3000;
constexpr WorkUnits kBudget = 10'000;
constexpr double kSize_m = 0.2;
constexpr WorkUnits kLeastBudget = 100;

// The dearest capped tick of work_prices, whose scenes do not fit into the caches, takes about
// twice as long for a unit as the dearest of these inputs, which do: 23 and 11 to 13 ns.
constexpr double kDearestPerMeasured = 2.0;

// A world in which every tick of a trembling hand spends its budget.
struct Input {
  std::unique_ptr<SurfaceIndex> index;
  ContactWorld world;
  double radius_m;
};

// Thin triangles that meet at the origin. The tests of a sphere near them take the nearest points
// of triangles; those of a point near the plane of such triangles take exact signs.
Input input(double radius_m, bool is_flat) {
  SeededRandom random(1);
  std::vector<Vec3> positions_m;
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < kTriangles; ++i) {
    Vec3 a = 0.5 * kSize_m * random.unit_vector();
    Vec3 b = a + 0.05 * random.in_box(kSize_m);
    if (is_flat) a.z() = b.z() = 0.0;
    positions_m.insert(positions_m.end(), {Vec3::Zero(), a, b});
    triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  Input input;
  input.radius_m = radius_m;
  const double stand_off_m = SolverScale::of(kSize_m, radius_m).stand_off_m;
  input.index = std::make_unique<SurfaceIndex>(SurfaceMesh::build(positions_m, triangles),
                                               AffineMap{}, radius_m + 2.0 * stand_off_m);
  input.world.bodies.push_back({input.index.get(), {}, true});
  input.world.bounds_solver = input.index->box();
  input.world.size_m = kSize_m;
  return input;
}

// The time of a unit in one pass of a hand to the origin and through it.
double pass_ns(const Input& input) {
  GodObjectSettings settings;
  settings.radius_m = input.radius_m;
  settings.accuracy.work_budget = kBudget;
  GodObject god_object = std::move(*GodObject::create(input.world, settings));
  god_object.place(Vec3(0.01, 0.02, 0.7) * kSize_m);
  SeededRandom random(2);
  double time_ns = 0.0;
  double units = 0.0;
  for (int tick = 0; tick < kTicks; ++tick) {
    const Vec3 goal_m = random.in_box(1e-3 * kSize_m);
    const auto start = std::chrono::steady_clock::now();
    const ProxyState state = god_object.move_to(goal_m);
    const std::chrono::duration<double, std::nano> time = std::chrono::steady_clock::now() - start;
    if (state.work < kBudget / 2) continue;
    time_ns += time.count();
    units += static_cast<double>(state.work);
  }
  return units > 0.0 ? time_ns / units : 0.0;
}

double shortest_ns(const Input& input) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) shortest = std::min(shortest, pass_ns(input));
  return shortest;
}

double measure_unit_ns() {
  double dearest_ns = 0.0;
  for (const auto& [radius_m, is_flat] :
       {std::pair(0.0, false), std::pair(0.03, false), std::pair(0.0, true)}) {
    dearest_ns = std::max(dearest_ns, shortest_ns(input(radius_m, is_flat)));
  }
  return kDearestPerMeasured * dearest_ns;
}

}  // namespace

double unit_price_ns() {
  static const double price_ns = measure_unit_ns();
  return price_ns;
}

MeasuredBudget work_budget_for(double dt_s, double unit_ns) {
  const double share = 1.0 + 1.0 / static_cast<double>(Accuracy::kEffectsPart);
  const double units = kWorkPerPeriod * dt_s * kSecond_ns / (unit_ns * share);
  const double digit = std::pow(10.0, std::floor(std::log10(std::max(units, 1.0))) - 1.0);
  const double rounded = std::floor(units / digit) * digit;
  return {std::max(kLeastBudget, static_cast<WorkUnits>(rounded)), unit_ns};
}

MeasuredBudget measured_work_budget(double dt_s) {
  return work_budget_for(dt_s, unit_price_ns());
}

}  // namespace palpate
