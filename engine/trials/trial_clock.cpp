#include "engine/trials/trial_clock.h"

#include <cmath>

#include "haptics/record_vectors.h"

namespace palpate {
namespace {

std::uint64_t ticks_in(double time_s, double dt_s) {
  return static_cast<std::uint64_t>(std::llround(time_s / dt_s));
}

}  // namespace

TrialClock::TrialClock(const TrialWay& way, const TrialSettings& settings, double proxy_radius_m,
                       double dt_s)
    : way_(way),
      settings_(settings),
      proxy_radius_m_(proxy_radius_m),
      dt_s_(dt_s),
      place_(way.path, way.green_along_m, settings.sphere_radius_m),
      long_loss_ticks_(ticks_in(kLongLoss_s, dt_s)),
      most_ticks_(ticks_in(settings.limit_s, dt_s)),
      strategy_measures_(dt_s) {}

void TrialClock::on_tick(const TickRecord& record) noexcept {
  if (status_) return;
  ++ticks_;
  if (ticks_ == 1) strategy_measures_.begin(record);
  if (record.faults & kFaultsWithoutSample) {
    status_ = TrialStatus::kFault;
    return;
  }
  const Vec3 contact_m = vec3(record.proxy_scene_m) - proxy_radius_m_ * vec3(record.normal_scene);
  if (!has_started_) has_started_ = record.contact && is_within(contact_m, way_.green_m);
  if (has_started_) {
    const double before_m = place_.along_m();
    const Vec3 outward = vec3(record.proxy_scene_m) - vec3(record.goal_scene_m);
    const bool is_good = record.contact && place_.see(contact_m, outward);
    if (is_good && was_good_) tracked_m_ += place_.along_m() - before_m;
    was_good_ = is_good;
    measure(record);
    const double whole_m = way_.red_along_m - way_.green_along_m;
    const bool is_far = place_.along_m() - way_.green_along_m >= kLeastWay * whole_m;
    if (record.contact && is_far && is_within(contact_m, way_.red_m)) status_ = TrialStatus::kDone;
  }
  if (!status_ && ticks_ >= most_ticks_) status_ = TrialStatus::kTimeout;
}

void TrialClock::measure(const TickRecord& record) noexcept {
  summary_.add(record);
  strategy_measures_.add(record);
  gap_ticks_ = record.contact ? 0 : gap_ticks_ + 1;
  if (gap_ticks_ == long_loss_ticks_) ++long_losses_;
  const Vec3 device_m = vec3(record.device_m);
  const Vec3 proxy_m = vec3(record.proxy_scene_m);
  if (has_last_) {
    device_path_m_ += (device_m - last_device_m_).norm();
    proxy_path_m_ += (proxy_m - last_proxy_m_).norm();
  }
  has_last_ = true;
  last_device_m_ = device_m;
  last_proxy_m_ = proxy_m;
  if (record.contact) measure_contact(record);
}

// A frictionless wall pushes along its normal only: the commanded force f has the ghost part
// |(I - N N^T) f|, and lacks |F*| - f . N of the full force F*.
void TrialClock::measure_contact(const TickRecord& record) noexcept {
  const Vec3 normal_device = pose_before(record).direction(vec3(record.normal_scene));
  const Vec3 force_N = vec3(record.force_device_N);
  const double along_N = force_N.dot(normal_device);
  ghost_sum_N_ += (force_N - along_N * normal_device).norm();
  missing_sum_N_ += vec3(record.full_force_device_N).norm() - along_N;
}

std::array<std::optional<double>, kMeasureCount> TrialClock::measures() const {
  std::array<std::optional<double>, kMeasureCount> m;
  if (!has_started_) return m;
  const RunSummary s = summary_.finish({});
  const auto count = [](std::uint64_t n) { return static_cast<double>(n); };
  // The first tick starts the clock; each further tick is dt later.
  const double total_s = count(s.ticks > 0 ? s.ticks - 1 : 0) * dt_s_;
  m[kTotalTime] = total_s;
  // The clock stops as the last tick begins: a contact found in it is no part of the total time.
  const bool ends_in_contact = s.contact_ticks > 0 && gap_ticks_ == 0;
  m[kContactTime] = count(s.contact_ticks - (ends_in_contact ? 1 : 0)) * dt_s_;
  m[kLosses] = count(s.losses_of_contact);
  m[kLosses100ms] = count(long_losses_);
  if (total_s > 0.0) {
    m[kLossesPerSecond] = *m[kLosses] / total_s;
    m[kLosses100msPerSecond] = *m[kLosses100ms] / total_s;
  }
  if (s.contact_ticks > 0) {
    constexpr double kDmPerM = 10.0;
    m[kPenetration] = s.mean_penetration_m;
    m[kPenetrationDm] = kDmPerM * s.mean_penetration_m;
    m[kContactAngle] = s.mean_contact_angle_deg;
    m[kShareWithin30deg] = s.share_within_30deg;
    m[kGhostForce] = ghost_sum_N_ / count(s.contact_ticks);
    m[kMissingForce] = missing_sum_N_ / count(s.contact_ticks);
  }
  m[kTrackedShare] = tracked_m_ / (way_.red_along_m - way_.green_along_m);
  m[kDevicePath] = device_path_m_;
  m[kProxyPath] = proxy_path_m_;
  m[kPortWork] = s.port_work_J;
  m[kWorkLost] = s.work_lost_J;
  for (std::size_t bit = 0; bit < kFaultCount; ++bit) {
    m[kFirstFaultMeasure + bit] = count(s.faults[bit]);
  }
  m[kMissedDeadlines] = 0.0;  // simulated time has no deadlines
  strategy_measures_.put(m);
  m[kDeviceTravel] = s.device_travel_m();
  return m;
}

}  // namespace palpate
