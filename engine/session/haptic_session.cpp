#include "engine/session/haptic_session.h"

#include <chrono>

namespace palpate {
namespace {

HapticSnapshot snapshot_of(const TickRecord& record, const ScenePose& pose) {
  const auto numbers = [](const Vec3& v) { return std::array{v.x(), v.y(), v.z()}; };
  HapticSnapshot s;
  s.sequence = record.tick + 1;
  s.time_s = record.time_s;
  s.q_wxyz = {pose.rotation.w(), pose.rotation.x(), pose.rotation.y(), pose.rotation.z()};
  s.o_m = numbers(pose.translation_m);
  s.proxy_scene_m = numbers(record.proxy_m);
  s.device_m = numbers(record.device_m);
  s.force_device_N = numbers(record.force_device_N);
  s.alpha_rad = record.alpha_rad;
  s.contact = record.contact ? 1 : 0;
  s.faults = record.faults;
  return s;
}

}  // namespace

void HapticSession::tick(double dt_s) noexcept {
  const Vec3 p_device_m = device_.read_position_m(dt_s);
  for (BeforeTick* before : before_) before->before_tick(time_s_, loop_);
  if (is_time_step(dt_s)) time_s_ += dt_s;
  const auto start = std::chrono::steady_clock::now();
  const TickRecord& record = loop_.tick(p_device_m, dt_s);
  const std::chrono::nanoseconds step = std::chrono::steady_clock::now() - start;
  device_.command_force_N(record.force_device_N);
  published_.publish(snapshot_of(record, loop_.T_device_scene()));
  if (observer_) observer_->on_tick(record, loop_.T_device_scene(), step.count());
}

}  // namespace palpate
