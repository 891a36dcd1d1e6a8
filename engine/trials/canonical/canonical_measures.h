#pragma once

// What is measured in a trial of the canonical protocol.

#include <cstdint>
#include <optional>

#include "engine/session/haptic_session.h"

namespace palpate {

// Sums over the ticks in contact. f: the commanded force; N: the contact normal, both in the device
// frame. Runs on the haptic thread and does not allocate there.
class CanonicalMeasures final : public TickObserver {
 public:
  // proxy_radius_m: 0 for a point. The contact normal of a sphere is less accurate.
  explicit CanonicalMeasures(double proxy_radius_m);

  void on_tick(const TickRecord& record) noexcept override;

  // Mean |(I - N N^T) f| over mean f.N. No value if the latter is 0 (to the accuracy of N) or if
  // there was no contact.
  std::optional<double> along_over_into() const;
  // The share of the ticks in contact whose contact angle is at most 30 deg (to the accuracy
  // of N), the limit of Barbagli and Salisbury. No value without contact.
  std::optional<double> share_within_30deg() const;

  // Whether a fault left a tick without a sample, or the proxy went beyond an end of the wall
  // (canonical_wall.h): the measures then are not those of the wall.
  bool is_spoilt() const { return is_spoilt_; }
  std::int64_t loop_ns() const { return loop_ns_; }  // computing time of the loop; measured

 private:
  double normal_error_rad_;  // of N
  bool is_spoilt_ = false;
  std::uint64_t contact_ticks_ = 0;
  std::uint64_t within_30deg_ = 0;
  double along_sum_N_ = 0.0;
  double into_sum_N_ = 0.0;
  double full_sum_N_ = 0.0;  // of the full force, before the projection
  std::int64_t loop_ns_ = 0;
};

}  // namespace palpate
