#pragma once

// What a tick touches, and whether a touch begins or ends: the last members of TickRecord.

#include <cstdint>

#include "haptics/proxy/face_materials.h"
#include "haptics/proxy/god_object.h"
#include "palpate/record.h"

namespace palpate {

// The touch of one haptic loop, from tick to tick. TickRecord and TouchEvent state the rules. Each
// function gets the loop's only record, with what the last tick wrote into it.
//
// Safe on the haptic thread: no allocation, lock or exception. One thread owns an object.
class TouchState {
 public:
  // The world must outlive this object.
  explicit TouchState(const ContactWorld& world) : world_(&world) {}

  // Completes the record of a tick whose sample was used. god_object: after the tick.
  void complete(const GodObject& god_object, TickRecord& record) noexcept {
    if (record.contact == 0) return complete_without_touch(record);
    const std::span<const FaceContact> contacts = god_object.contacts();
    if (contacts.size() != 1) [[unlikely]] {
      named_ = kNoFace;
      const Vec3 goal_solver =
          world_->to_solver(Vec3::Map(record.goal_scene_m));  // as the loop computes it
      name_largest(god_object.contact(), god_object.proxy() - goal_solver, record);
    } else if (const FaceRef& face = contacts[0].face; face != named_) {
      named_ = face;
      record.body = static_cast<std::int32_t>(face.body);
      record.material = material_of(face);
      record.contacts = 1;
    }
    record.touch = touched_ ? 0 : kTouchBegan;
    touched_ = true;
  }

  // Completes the record of a tick that does not touch.
  void complete_without_touch(TickRecord& record) noexcept {
    if (!touched_ && record.touch == 0) return;  // the record says so already
    named_ = kNoFace;
    record.body = record.material = kNothingTouched;
    record.contacts = 0;
    record.touch = touched_ ? kTouchEnded : 0;
    touched_ = false;
  }

  // Names the contact that bears most, of none or several. lag_m: from the goal to the proxy,
  // solver axes.
  void name_largest(const ContactView& contact, const Vec3& lag_m,
                    TickRecord& record) const noexcept;

 private:
  static constexpr FaceRef kNoFace{~std::uint32_t{0}, 0};

  std::int32_t material_of(const FaceRef& face) const noexcept {
    if (!world_->materials) return kNothingTouched;
    return world_->materials->material(face.body, world_->bodies[face.body].index->face(face.slot));
  }

  const ContactWorld* world_;
  FaceRef named_ = kNoFace;  // the record names this face, and no other
  bool touched_ = false;     // the last tick touches
};

}  // namespace palpate
