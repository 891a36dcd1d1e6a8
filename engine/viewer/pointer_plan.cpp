#include "engine/viewer/pointer_plan.h"

#include <algorithm>

#include "haptics/record_vectors.h"

namespace palpate {

void PointerPlan::point(const PointerMessage& message) {
  if (message.sequence <= wish_.sequence) return;
  wish_.sequence = message.sequence;
  wish_.mode = message.holds ? Mode::kHeld : Mode::kFree;
  wish_.target_m = message.target_m;
  publish();
}

void PointerPlan::let_go() {
  wish_.mode = Mode::kFree;
  wish_.sequence = 0;  // the next page counts from 1
  publish();
}

void PointerPlan::start() {
  wish_.mode = Mode::kStarts;
  publish();
}

void PointerPlan::publish() {
  ++wish_.number;
  mailbox_.publish(wish_);
  newest_.store(wish_.number, std::memory_order_release);
}

HandTarget PointerPlan::target(double time_s, const ScenePose& /*T_device_scene*/,
                               const TickRecord& last) noexcept {
  take_wish(time_s);
  const Vec3 device_m = vec3(last.device_m);
  if (mode_ == Mode::kHeld && time_s - wish_time_s_ > kPatience_s) mode_ = Mode::kFree;
  if (mode_ == Mode::kHeld) target_m_ = Vec3(used_.target_m.data());
  if (mode_ == Mode::kStarts) move_to_start(time_s, device_m);
  if (mode_ == Mode::kFree) target_m_ = device_m;
  last_time_s_ = time_s;
  return {target_m_, Vec3::Zero()};
}

void PointerPlan::take_wish(double time_s) {
  if (newest_.load(std::memory_order_acquire) == used_.number) return;
  if (!mailbox_.read(used_)) return;
  mode_ = used_.mode;
  wish_time_s_ = time_s;
  begins_ = mode_ == Mode::kStarts;
}

void PointerPlan::move_to_start(double time_s, const Vec3& device_m) {
  if (begins_) target_m_ = device_m;
  if (begins_ || target_m_ != start_m_) moved_s_ = time_s;
  if (time_s - moved_s_ > kPatience_s) mode_ = Mode::kFree;
  begins_ = false;
  const Vec3 rest_m = start_m_ - target_m_;
  const double step_m = kStartSpeed_m_per_s * (time_s - last_time_s_);
  const double rest_length_m = rest_m.norm();
  target_m_ =
      rest_length_m <= step_m ? start_m_ : Vec3(target_m_ + rest_m * (step_m / rest_length_m));
}

}  // namespace palpate
