#include "engine/simulation/port_loop.h"

#include <cmath>
#include <utility>

namespace palpate {
namespace {

constexpr double kSolid_m = 0.3;  // how far a solid reaches from the origin, along each axis

// The outline of the solid in the plane z = 0, counter-clockwise. Each vertex sees the first one.
std::vector<Vec2> outline_of(PortShape shape) {
  constexpr double s = kSolid_m;
  if (shape == PortShape::kWall) return {{0, -s}, {0, s}, {-s, s}, {-s, -s}};
  return {{0, 0}, {s, s}, {-s, s}, {-s, -s}, {s, -s}};
}

// The prism over an outline, from z = -kSolid_m to kSolid_m.
Result<Scene> solid(PortShape shape) {
  const std::vector<Vec2> outline = outline_of(shape);
  const auto n = static_cast<std::uint32_t>(outline.size());
  std::vector<Vec3> positions_m;
  for (const double z_m : {-kSolid_m, kSolid_m}) {
    for (const Vec2& p : outline) positions_m.emplace_back(p.x(), p.y(), z_m);
  }
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    triangles.push_back({i, j, n + j});
    triangles.push_back({i, n + j, n + i});
    if (i == 0 || j == 0) continue;
    triangles.push_back({0, j, i});
    triangles.push_back({n, n + i, n + j});
  }
  SceneDescription description;
  description.meshes.push_back({"solid", std::move(positions_m), std::move(triangles)});
  description.nodes.emplace_back();
  description.nodes.back().name = "solid";
  description.tree.resize(1);
  return Scene::compile(std::move(description));
}

}  // namespace

Result<std::unique_ptr<PortLoop>> PortLoop::create(const PortLoopSettings& settings,
                                                   std::vector<BeforeTick*> changes) {
  Result<Scene> scene = solid(settings.shape);
  if (!scene) return scene.error();
  std::unique_ptr<PortLoop> loop(new PortLoop(settings, std::move(*scene)));
  const DeviceDescription& device = settings.device.device;
  const auto actuation = ActuationModel::from_counts(device.sensed_axes, device.motor_count);
  if (!actuation) return actuation.error();
  HapticSettings haptics;
  haptics.a4.enabled = false;
  haptics.coupling = settings.coupling;
  if (settings.strategy) set_strategy(*settings.strategy, haptics);
  haptics.initial_pose.rotation = Quat(loop->R_device_shape_);
  RunSetup setup{*actuation, haptics, loop->dt_s_, {}};
  setup.device = device;
  setup.governor = settings.governor;
  auto rig = Rig::create(loop->scene_, setup, loop->device_,
                         {.changes = std::move(changes), .observers = {loop.get()}});
  if (!rig) return rig.error();
  loop->rig_ = std::move(*rig);
  if (const auto problem = loop->rig_->session().start()) {
    return Error{ErrorCode::kInvalidArgument, "", "device", *problem, ""};
  }
  return loop;
}

PortLoop::PortLoop(const PortLoopSettings& settings, Scene scene)
    : dt_s_(1.0 / settings.rate_Hz),
      R_device_shape_(Eigen::AngleAxisd(settings.turn_rad, Vec3::UnitZ()).toRotationMatrix()),
      scene_(std::move(scene)),
      device_(settings.device) {}

void PortLoop::tick_late(double late_s) {
  device_.idle(late_s);
  rig_->session().tick(dt_s_, std::llround(1e9 * late_s), 0);
}

void PortLoop::run(double seconds) {
  const auto ticks = std::llround(seconds / dt_s_);
  for (std::int64_t n = 0; n < ticks; ++n) tick();
}

GovernorStatus PortLoop::governor() const {
  GovernorStatus status;
  rig_->session().latest(status);
  return status;
}

void PortLoop::on_tick(const TickRecord& record) noexcept {
  last_ = record;
  rules_ |= record.rules;
}

void PortLoop::on_trip(const GovernorTrip& trip) noexcept {
  if (!has_tripped()) trip_ = trip;
}

}  // namespace palpate
