#pragma once

// The contact angles of a hand without delay on the paper's four objects, as a table.

#include <string>
#include <vector>

#include "benchmarks/contour_hand.h"
#include "geometry/base/result.h"

namespace palpate::bench {

// One case and its result.
struct ContourCase {
  std::string object;  // a name of paper_objects()
  ContourRound round;
  ContourAngle angle;
};

// Measures all cases: every object in 20 and 27 s, from 0 and 45 deg, with both rules of alignment.
// models_dir: the folder of the objects' files. The time is simulated, so that the results depend
// only on the code. Takes about a second. The error names the file.
Result<std::vector<ContourCase>> measure_contour_angles(const std::string& models_dir);

// The table in CSV: object, start_orientation_deg, align, duration_s, mean_contact_angle_deg,
// contact_share. One line per case; angles and shares have four decimals.
std::string contour_angles_csv(const std::vector<ContourCase>& cases);

}  // namespace palpate::bench
