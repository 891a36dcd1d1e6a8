#pragma once

// A device with three sensed and three actuated axes.

#include "haptics/a4/actuation.h"

namespace palpate::test {

inline ActuationModel three_axes() {
  return ActuationModel::from_counts(3, 3).value();
}

}  // namespace palpate::test
