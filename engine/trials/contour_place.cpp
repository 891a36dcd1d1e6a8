#include "engine/trials/contour_place.h"

#include <algorithm>

namespace palpate {

ContourPlace::ContourPlace(const HandPath& path, double along_m, double sphere_radius_m)
    : path_(path),
      lengths_m_(path.lengths_m()),
      off_m_(kOffPath * sphere_radius_m),
      along_m_(along_m),
      leg_(leg_at(lengths_m_, along_m)) {}

bool ContourPlace::see(const Vec3& contact_m, const Vec3& outward) {
  const double first_m = along_m_ - kKept_m;
  const double last_m = along_m_ + kReach_m;
  std::size_t leg = leg_;
  while (leg > 0 && lengths_m_[leg] > first_m) --leg;
  double nearest_m = off_m_;
  double found_m = 0.0;
  std::size_t found_leg = leg;
  bool is_found = false;
  for (; leg + 1 < path_.points.size() && lengths_m_[leg] <= last_m; ++leg) {
    const double length_m = lengths_m_[leg + 1] - lengths_m_[leg];
    if (length_m == 0.0 || outward.dot(path_.points[leg].inward) > 0.0) continue;
    const Vec3& from = path_.points[leg].p_m;
    const Vec3 tangent = (path_.points[leg + 1].p_m - from) / length_m;
    const double at_m = std::clamp((contact_m - from).dot(tangent), 0.0, length_m);
    if (lengths_m_[leg] + at_m < first_m || lengths_m_[leg] + at_m > last_m) continue;
    const double off_m = (contact_m - from - at_m * tangent).norm();
    if (off_m > nearest_m) continue;
    nearest_m = off_m;
    found_m = lengths_m_[leg] + at_m;
    found_leg = leg;
    is_found = true;
  }
  if (is_found && found_m > along_m_) {
    along_m_ = found_m;
    leg_ = found_leg;
  }
  return is_found;
}

}  // namespace palpate
