#include "engine/trials/canonical/canonical_hand.h"

#include <algorithm>
#include <cmath>

namespace palpate {

double canonical_duration_s(const OperatorParameters& person, CanonicalMotion motion) {
  const double pressed_s = kPress_s + kHold_s;
  return motion == CanonicalMotion::kPressed ? pressed_s
                                             : pressed_s + kStroke_m / person.speed_m_per_s;
}

CanonicalHand::CanonicalHand(const OperatorParameters& person, CanonicalMotion motion,
                             double display_Hz, double proxy_radius_m)
    : motion_(motion),
      sight_delay_s_(person.sight_delay_s),
      press_depth_m_(person.press_depth_m),
      speed_m_per_s_(person.speed_m_per_s),
      duration_s_(canonical_duration_s(person, motion)),
      picture_s_(1.0 / display_Hz),
      outside_m_(proxy_radius_m + kComesFrom * person.press_depth_m) {
  // Besides the pictures on their way, one that is seen and one that is being taken.
  constexpr double kMorePictures = 3.0;
  pictures_.resize(
      static_cast<std::size_t>(std::ceil(sight_delay_s_ / picture_s_) + kMorePictures));
}

HandTarget CanonicalHand::target(double time_s, const ScenePose& T_device_scene,
                                 const TickRecord&) noexcept {
  const bool has_begun = seen_ > 0;
  const Picture* const picture = newest_seen(time_s, T_device_scene);
  if (!picture) return {T_device_scene.point(start_scene_m()), Vec3::Zero()};
  if (!has_begun) begun_s_ = time_s;
  const double moving_s = time_s - begun_s_;
  is_over_ = moving_s >= duration_s_;
  const HandTarget aimed = aim(moving_s);
  return {picture->T_device_scene.point(aimed.position_m),
          picture->T_device_scene.direction(aimed.velocity_m_per_s)};
}

// Null if the person has seen nothing yet.
const CanonicalHand::Picture* CanonicalHand::newest_seen(double time_s,
                                                         const ScenePose& T_device_scene) {
  if (time_s >= static_cast<double>(taken_) * picture_s_) {
    pictures_[taken_ % pictures_.size()] = {time_s, T_device_scene};
    ++taken_;
  }
  while (seen_ < taken_ && pictures_[seen_ % pictures_.size()].time_s <= time_s - sight_delay_s_) {
    ++seen_;
  }
  return seen_ > 0 ? &pictures_[(seen_ - 1) % pictures_.size()] : nullptr;
}

// The target in the scene frame.
HandTarget CanonicalHand::aim(double moving_s) const {
  const double way_m = (kComesFrom + 1.0) * press_depth_m_;
  HandTarget aim;
  aim.position_m.x() = outside_m_ - way_m * std::min(moving_s / kPress_s, 1.0);
  if (moving_s < kPress_s) aim.velocity_m_per_s.x() = -way_m / kPress_s;
  if (motion_ == CanonicalMotion::kPressed) return aim;
  const double stroked_m = speed_m_per_s_ * std::max(0.0, moving_s - kPress_s - kHold_s);
  aim.position_m.y() = std::min(stroked_m, kStroke_m);
  if (stroked_m > 0.0 && stroked_m < kStroke_m) aim.velocity_m_per_s.y() = speed_m_per_s_;
  return aim;
}

}  // namespace palpate
