#pragma once

// The clock and the measures of a trial.

#include <array>
#include <cstdint>
#include <optional>

#include "engine/session/haptic_session.h"
#include "engine/session/run_summary.h"
#include "engine/trials/contour_place.h"
#include "engine/trials/strategy_measures.h"
#include "engine/trials/trial.h"

namespace palpate {

// Starts at the first tick in contact within the green sphere, and stops at the first contact
// within the red sphere after the place has passed the share kLeastWay of the way. All measures
// cover the ticks from the start to the stop. Runs on the haptic thread and does not allocate
// there.
class TrialClock final : public TickObserver {
 public:
  // The share of the way that the place must have passed before the clock stops.
  static constexpr double kLeastWay = 0.8;
  // An interval of at least this length without contact counts as a long loss.
  static constexpr double kLongLoss_s = 0.1;

  // `way` must outlive the clock. settings.limit_s counts from the start of the trial.
  TrialClock(const TrialWay& way, const TrialSettings& settings, double proxy_radius_m,
             double dt_s);

  void on_tick(const TickRecord& record) noexcept override;

  bool has_started() const { return has_started_; }
  // After the start: the place on the contour that the contact has reached, along the way.
  double along_m() const { return place_.along_m(); }
  // The last tick was a contact that moved or confirmed the place.
  bool is_on_way() const { return was_good_; }
  bool is_over() const { return status_.has_value(); }
  // Requires is_over().
  TrialStatus status() const { return *status_; }
  // The measures, without kRecoveries. A measure that is undefined has no value.
  std::array<std::optional<double>, kMeasureCount> measures() const;

 private:
  void measure(const TickRecord& record) noexcept;
  void measure_contact(const TickRecord& record) noexcept;
  bool is_within(const Vec3& contact_m, const Vec3& centre_m) const {
    return (contact_m - centre_m).norm() <= settings_.sphere_radius_m;
  }

  const TrialWay& way_;
  TrialSettings settings_;
  double proxy_radius_m_;
  double dt_s_;
  ContourPlace place_;
  std::uint64_t long_loss_ticks_;
  std::uint64_t most_ticks_;

  std::uint64_t ticks_ = 0;  // since the start of the trial
  bool has_started_ = false;
  std::optional<TrialStatus> status_;
  SummaryAccumulator summary_;
  StrategyMeasures strategy_measures_;
  std::uint64_t long_losses_ = 0;
  std::uint64_t gap_ticks_ = 0;
  bool was_good_ = false;  // the last tick moved or confirmed the place
  double tracked_m_ = 0.0;
  double device_path_m_ = 0.0;
  double proxy_path_m_ = 0.0;
  bool has_last_ = false;
  Vec3 last_device_m_ = Vec3::Zero();
  Vec3 last_proxy_m_ = Vec3::Zero();
  double ghost_sum_N_ = 0.0;
  double missing_sum_N_ = 0.0;
};

}  // namespace palpate
