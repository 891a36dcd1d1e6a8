#pragma once

// Judges what a page makes of the walls on a device that moves motors.

#include <string>

#include "geometry/base/result.h"

namespace palpate {

// The network thread owns it while the session lives.
class WallJudge {
 public:
  virtual ~WallJudge() = default;

  // Judges a number of the page (PageSettings) before it is set. An Error refuses it. Otherwise
  // what the person must know, or nothing.
  virtual Result<std::string> judge(const std::string& name, double value) = 0;
  // The number that was judged last was set.
  virtual void keep() = 0;
};

}  // namespace palpate
