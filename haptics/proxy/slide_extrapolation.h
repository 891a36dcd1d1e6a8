#pragma once

// The extrapolation of a slow sphere's slides to where they lead together.

#include <algorithm>
#include <optional>
#include <utility>

#include "haptics/proxy/contact.h"

namespace palpate {

// What a slow sphere remembers of its last slides: how far the next one may overreach, from where
// the next leap begins, and which feature the sphere moved round last. A tick that continues the
// last one keeps it. Solver frame, m.
class SlideExtrapolation {
 public:
  // The sphere at `proxy` has become slow: nothing is known of earlier slides.
  void begin(const Vec3& proxy) {
    last_slide_m_ = 0.0;
    last_round_.reset();
    begin_leap(proxy, 1.0);
  }

  // The factor by which a slide that ended at `proxy` must be multiplied to end where it and all
  // later slides together would end. It extrapolates to where slides vanish if they continue to
  // shrink along the path as they have since the last one (a secant). least_m2: the length of a
  // slide times the length by which a reach must extend it while slides do not shrink.
  double reach_of(const Vec3& slide, const Vec3& proxy, double least_m2) {
    const Vec3 from = proxy - slide;
    const Vec3 path = from - std::exchange(last_slide_from_, from);
    const double last_m = std::exchange(last_slide_m_, slide.norm());
    const double path_m = path.norm();
    if (last_m == 0.0 || slide.dot(path) < kSameDirection * last_slide_m_ * path_m) {
      reach_ = 1.0;
      return reach_;
    }
    const double shrinks_m = last_m - last_slide_m_;
    if (shrinks_m > 0.0) {
      reach_ = std::min(path_m / shrinks_m, kMostGrowth * reach_);
    } else {
      const double least_m = least_m2 / last_slide_m_;
      reach_ = std::max(kFasterEachTime * reach_, least_m / last_slide_m_);
    }
    return reach_;
  }
  // The extension of a slide of this length by beyond_m brought the sphere no nearer.
  void fail(double beyond_m, double slide_m) {
    reach_ = std::max(1.0, kLessAfterFailure * beyond_m / slide_m);
  }

  // Whether a leap is due after this step.
  bool is_leap_due() {
    if (steps_to_leap_ > 0) --steps_to_leap_;
    return steps_to_leap_ == 0;
  }
  // The displacement of the leap from `proxy`.
  Vec3 leap_from(const Vec3& proxy) const { return leap_reach_ * (proxy - leap_from_); }
  // A leap has ended at `proxy`. Each success multiplies the length of the next leap.
  void end_leap(const Vec3& proxy, bool is_nearer) {
    begin_leap(proxy, is_nearer ? kFasterEachTime * leap_reach_ : 1.0);
  }

  // The sphere moves round this feature. Returns the last one.
  std::optional<FaceContact> go_round(const FaceContact& feature) {
    return std::exchange(last_round_, feature);
  }

 private:
  // Number of steps from one leap to the next.
  static constexpr int kStepsPerLeap = 8;
  // The least cosine of the angle between two successive slides that count as the same direction.
  static constexpr double kSameDirection = 0.9;
  // The largest growth of an extrapolation from one slide to the next: a change of curvature
  // farther on is approached in small steps.
  static constexpr double kMostGrowth = 16.0;
  // Growth of an extrapolation after each success.
  static constexpr double kFasterEachTime = 4.0;
  // Length of the first extrapolation after a failure, relative to the length that failed.
  static constexpr double kLessAfterFailure = 1.0 / 64;

  void begin_leap(const Vec3& proxy, double reach) {
    leap_from_ = proxy;
    leap_reach_ = reach;
    steps_to_leap_ = kStepsPerLeap;
  }

  double last_slide_m_ = 0.0;              // length of the last complete slide along planes
  Vec3 last_slide_from_ = Vec3::Zero();    // start of that slide
  double reach_ = 1.0;                     // factor by which the last slide was extended
  Vec3 leap_from_ = Vec3::Zero();          // start of the path that the next leap extrapolates
  double leap_reach_ = 1.0;                // length of the next leap, relative to that path
  int steps_to_leap_ = 0;                  // steps left until the next leap
  std::optional<FaceContact> last_round_;  // feature that the sphere moved round last
};

}  // namespace palpate
