#pragma once

// The coefficients of Coulomb friction at a contact.

#include "palpate/record.h"  // FrictionState

namespace palpate {

// The coefficients of Coulomb friction: no unit, finite, 0 <= dynamic <= static.
struct FrictionCone {
  // A sticking proxy keeps its position while its tangential lag is at most this multiple of the
  // penetration depth.
  double static_friction = 0.0;
  // A sliding proxy has a tangential lag of this multiple of the penetration depth.
  double dynamic_friction = 0.0;

  // Whether the contact has friction.
  bool holds() const { return static_friction > 0.0; }
};

}  // namespace palpate
