#pragma once

// What a page is told of a hand that its pointer moves.

#include <cstdint>

#include "geometry/base/types.h"

namespace palpate {

// Called on the haptic thread.
class PointedHand {
 public:
  virtual ~PointedHand() = default;
  // Of the newest pointer message that the last tick used; 0: none.
  virtual std::uint64_t sequence() const noexcept = 0;
  virtual const Vec3& target_m() const noexcept = 0;  // device frame
  virtual bool is_held() const noexcept = 0;          // by a page
  virtual bool has_target() const noexcept = 0;
};

}  // namespace palpate
