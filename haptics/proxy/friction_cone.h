#pragma once

// How much of its depth a contact can hold sideways, and whether it does.

#include "palpate/record.h"  // FrictionState

namespace palpate {

// Coulomb's friction. No unit, finite, 0 <= dynamic <= static.
struct FrictionCone {
  double static_friction = 0.0;   // a proxy that sticks keeps its place while its tangential lag is
                                  // at most so many times its depth
  double dynamic_friction = 0.0;  // one that slides has a lag of so many times its depth

  bool holds() const { return static_friction > 0.0; }
};

}  // namespace palpate
