#pragma once

// The plan of the canonical protocol: what `palpate experiment run` reads if the plan has the key
// `protocol`.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/session/run_setup.h"
#include "engine/trials/canonical/canonical_hand.h"
#include "engine/trials/operator_file.h"
#include "geometry/base/result.h"

namespace palpate {

// The name of the plan that ships, canonical.json, and the word of the key `protocol`.
inline constexpr std::string_view kCanonicalPlan = "canonical";

inline constexpr std::size_t kMostAngles = 181;

// The conditions of a trial.
struct CanonicalCell {
  double angle_deg = 0.0;
  CanonicalMotion motion = CanonicalMotion::kPressed;
  bool rotates = false;
};

// A plan. Its JSON is an object with these keys; those in brackets are optional:
//   palpate_plan     1
//   protocol         "canonical"
//   name             text
//   seed             whole number, below 2^53
//   participants     each does every trial
//   device           the settings of `run` (plan_device.h) with one motor, without place and
//                    plane_height_m: the angles place the wall
//   display_Hz
//   [angles_deg]     between the wall's normal and the motor's axis, ascending, from 0 to 90; 0 to
//                    90 in steps of 15 if absent
//   operator         a name of kShippedOperators, or the path of an operator file
struct CanonicalPlan {
  std::string path;  // as the caller named it
  std::string name;
  std::uint64_t seed = 0;
  int participants = 1;
  RunSettings device;
  double display_Hz = 40.0;
  std::vector<double> angles_deg;
  OperatorFile person;
  // Of the JSON with sorted keys and with the name of the operator, of the wall and of the motion.
  std::uint64_t hash = 0;

  // Angle x motion x rotation, in this order: pressed before stroked, NoR before R.
  std::vector<CanonicalCell> cells() const;
};

// An error names the element, such as /angles_deg/2. path: the path of the file, for messages.
// folder: the folder to which the path of the operator file is relative; empty: the current folder.
Result<CanonicalPlan> parse_canonical_plan(std::string_view text, const std::string& path,
                                           const std::string& folder);

// name_or_path: kCanonicalPlan, or the path of a file. No value if the file is a plan without the
// key `protocol` (plan.h).
Result<std::optional<CanonicalPlan>> load_canonical_plan(const std::string& name_or_path);

}  // namespace palpate
