#pragma once

// Recorded positions of a device, read from a text file.

#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// Device positions in the device frame, metres, in the file's order; at least one.
//
// A line contains "x y z" or "t x y z", separated by blanks or commas; every line has the same
// number of columns. t, in any unit, must be finite and strictly increase; its values have no other
// effect. x, y and z may be nan or inf, in upper or lower case; such samples are kept. "#" begins a
// comment, empty lines are skipped, and lines end with LF or CRLF. The first line may be a header:
// none of its fields is a number, and the column names that it contains (t or time, x, y, z, with
// or without a unit) are in the order above.
//
// A trace (trace_csv.h) is also a trajectory. It is recognised by its columns device_x, device_y
// and device_z, which may be in any order and among any other columns. Its device positions are
// read, including nan and inf; "t" is treated as above. Each line of a trace has as many columns as
// the header and ends with a newline; a last line without a newline counts as cut off.
//
// The decimal separator is a point in every locale. Any other content is an error that names the
// line. Thread-safe.
Result<std::vector<Vec3>> read_trajectory(const std::string& path);

}  // namespace palpate
