#pragma once

// The step of the god-object that is under way: the contact planes that it uses and their solution.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "geometry/exact/orientation.h"
#include "haptics/proxy/contact.h"
#include "haptics/proxy/plane_projection.h"

namespace palpate {

// The contact planes that a proxy has met, the contacts that they belong to, and the last solution
// for them. A copy restores all of it. Solver frame, m.
//
// Invariants: the present position satisfies every plane (its offset is <= 0), at most
// kMaxContactPlanes planes are known, and no two are the same but for rounding. A plane of a face
// that is not touched yet is not current: one state says both.
class ProxyStep {
 public:
  // What is known of the planes.
  enum class Planes : std::uint8_t {
    kEarlier,  // one may have been computed at an earlier position
    kCurrent,  // all were computed at the present position, from faces that the proxy touches
    kNextFace  // one belongs to a face that is not touched yet
  };

  // Two contacts with the same face have the same plane if a cosine cannot distinguish their
  // normals; contacts with different faces, if their normals differ by rounding only.
  static constexpr double kSameNormal = 0x1p-25;
  static constexpr double kSameNormalOfOther = 32 * kUnitRoundoff;

  Planes state() const { return state_; }
  bool is_current() const { return state_ == Planes::kCurrent; }
  bool is_over_next_face() const { return state_ == Planes::kNextFace; }

  std::span<const ContactPlane> planes() const {
    return std::span(planes_).first(static_cast<std::size_t>(count_));
  }
  // The contacts that the planes belong to.
  std::span<const FaceContact> contacts() const {
    return std::span(contacts_).first(static_cast<std::size_t>(count_));
  }
  // The planes and, after them, unused ones. A solution may outlive its planes.
  const std::array<ContactPlane, kMaxContactPlanes>& all_planes() const { return planes_; }

  // The last solution: the planes that are active in it, their contacts, and the displacement.
  const PlaneProjection& solution() const { return solution_; }
  bool is_solved() const { return solution_.solved; }
  int active_count() const { return solution_.active_count; }
  const ContactPlane& active_plane(std::size_t i) const { return planes_[solution_.active[i]]; }
  const FaceContact& active_contact(std::size_t i) const { return contacts_[solution_.active[i]]; }
  FaceContact& active_contact(std::size_t i) { return contacts_[solution_.active[i]]; }
  const Vec3& displacement_m() const { return solution_.displacement_m; }
  Vec3& displacement_m() { return solution_.displacement_m; }

  // Forgets all planes and the solution.
  void clear() {
    clear_planes();
    clear_solution();
    state_ = Planes::kEarlier;
  }
  void clear_planes() { count_ = 0; }
  void clear_solution() { solution_ = {}; }

  void solve(const PlaneProjection& solution) { solution_ = solution; }
  // All planes, at most three, are active with this displacement.
  void solve_by_all(const Vec3& displacement_m) {
    solution_ = {displacement_m, {0, 1, 2}, count_, true};
  }
  // The first plane takes the place of the only active one.
  void solve_by_first() { solution_.active[0] = 0; }

  // All planes have been computed at the present position.
  void set_current() { state_ = Planes::kCurrent; }
  // The proxy has left the position, or a plane is not of a face that it touches.
  void set_earlier() { state_ = Planes::kEarlier; }
  // The plane that was added last is that of the next face.
  void set_over_next_face() { state_ = Planes::kNextFace; }

  // Moves the proxy along `displacement`, which the planes allow.
  void advance(const Vec3& displacement) {
    state_ = Planes::kEarlier;
    for (int i = 0; i < count_; ++i) {
      ContactPlane& plane = planes_[i];
      plane.offset_m = std::min(0.0, plane.offset_m - plane.normal.dot(displacement));
    }
  }

  // Returns to an earlier step. A plane of a next face does not count as one there: it is used for
  // one step only.
  void return_to(const ProxyStep& earlier) {
    *this = earlier;
    if (is_over_next_face()) state_ = Planes::kEarlier;
  }

  // Adds the plane of a contact, with an offset <= 0. If there is no space for it, all planes that
  // are not active make room. False if the planes are unchanged.
  bool add(const FaceContact& contact, const ContactPlane& plane) {
    int known = 0;
    if (is_known(contact, plane, known)) {
      ContactPlane& there = planes_[known];
      const ContactPlane before = there;
      if (contacts_[known].face == contact.face || plane.offset_m > there.offset_m) {
        there = plane;
        contacts_[known] = contact;
      }
      return there.normal != before.normal || there.offset_m != before.offset_m;
    }
    if (count_ == kMaxContactPlanes) drop_inactive();
    planes_[count_] = plane;
    contacts_[count_] = contact;
    ++count_;
    return true;
  }

  // Whether there are active planes and the proxy is farther than near_m from all of them.
  bool is_off_planes(double near_m) const {
    for (int i = 0; i < solution_.active_count; ++i) {
      if (planes_[solution_.active[i]].offset_m >= -near_m) return false;
    }
    return solution_.active_count > 0;
  }

  // Whether each of the active planes has its face within reach_m of the proxy.
  bool touches_faces(double reach_m) const {
    for (int i = 0; i < solution_.active_count; ++i) {
      if (contacts_[solution_.active[i]].clearance_m > reach_m) return false;
    }
    return true;
  }

  // The part of a lag, in [0, 1], up to the first active plane.
  double part_to_planes(const Vec3& lag) const {
    double part = 1.0;
    for (int i = 0; i < solution_.active_count; ++i) {
      const ContactPlane& plane = planes_[solution_.active[i]];
      const double approach_m = plane.normal.dot(lag);
      if (approach_m < 0.0) part = std::min(part, plane.offset_m / approach_m);
    }
    return part;
  }

 private:
  // Whether a plane is already present, from the same face or from another one; faces that share a
  // touched edge or vertex, or lie in one plane, have the same contact plane.
  bool is_known(const FaceContact& contact, const ContactPlane& plane, int& known) const {
    for (known = 0; known < count_; ++known) {
      const double difference = (planes_[known].normal - plane.normal).squaredNorm();
      const bool is_same_face = contacts_[known].face == contact.face;
      const double same = is_same_face ? kSameNormal : kSameNormalOfOther;
      if (difference <= same * same) return true;
    }
    return false;
  }

  void drop_inactive() {
    const auto active = solution_.active;  // in ascending order, so moving down is safe
    for (int i = 0; i < solution_.active_count; ++i) {
      planes_[i] = planes_[active[i]];
      contacts_[i] = contacts_[active[i]];
      solution_.active[i] = i;
    }
    count_ = solution_.active_count;
  }

  std::array<ContactPlane, kMaxContactPlanes> planes_{};
  std::array<FaceContact, kMaxContactPlanes> contacts_{};
  int count_ = 0;
  Planes state_ = Planes::kEarlier;
  PlaneProjection solution_;
};

}  // namespace palpate
