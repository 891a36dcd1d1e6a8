#pragma once

// What a tick touches, and whether a touch begins or ends: the last members of TickRecord.

#include "haptics/proxy/face_materials.h"
#include "haptics/proxy/proxy_state.h"
#include "palpate/record.h"

namespace palpate {

// The touch of one haptic loop, from tick to tick. TickRecord and TouchEvent state the rules.
//
// Safe on the haptic thread: no allocation, lock or exception. One thread owns an object.
class TouchState {
 public:
  // materials: of the world's faces; null: unknown. Must outlive this object.
  explicit TouchState(const FaceMaterials* materials) : materials_(materials) {}

  // Completes the record of a tick with a sample that was used. contact: that of the god-object
  // after this tick. lag_m: from the goal to the proxy, solver axes.
  void complete(const ContactView& contact, const Vec3& lag_m, TickRecord& record) noexcept {
    if (record.contact == 0) return complete_without_touch(record);
    if (contact.contacts().size() == 1) [[likely]] {
      name_only(contact, record);
    } else {
      name_largest(contact, lag_m, record);
    }
    record.touch = touched_ ? 0 : kTouchBegan;
    touched_ = true;
  }

  // Completes the record of a tick that does not touch.
  void complete_without_touch(TickRecord& record) noexcept {
    record.body = record.material = kNothingTouched;
    record.contacts = 0;
    record.touch = touched_ ? kTouchEnded : 0;
    touched_ = false;
  }

 private:
  void name_only(const ContactView& contact, TickRecord& record) const noexcept {
    const FaceRef& face = contact.contacts()[0].face;
    record.body = static_cast<std::int32_t>(face.body);
    record.material = material_of(contact.world(), face);
    record.contacts = 1;
  }
  void name_largest(const ContactView& contact, const Vec3& lag_m,
                    TickRecord& record) const noexcept;
  std::int32_t material_of(const LiveWorld& world, const FaceRef& face) const noexcept {
    if (!materials_) return kNothingTouched;
    return materials_->material(face.body, world.body(face.body).index->face(face.slot));
  }

  const FaceMaterials* materials_;
  bool touched_ = false;  // the last tick touches
};

}  // namespace palpate
