#pragma once

// Recorded positions of a device, read from a text file.

#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

// Device positions in the device frame, metres, in the file's order; at least one.
//
// A line holds "x y z" or "t x y z", separated by blanks or commas, the same number of columns on
// every line. t, in any unit, is finite and strictly increases; it is otherwise ignored. nan and
// inf, in any case, are samples of x, y and z. "#" begins a comment, empty lines are skipped, CRLF
// ends a line as well as LF. The first line may be a header: no field of it is a number, and names
// it gives columns (t or time, x, y, z, with or without a unit) agree with the order above.
//
// A trace (trace_csv.h) is a trajectory as well, known by its columns device_x, device_y and
// device_z, in any order among any others: its device positions are read, nan and inf as the
// samples that they were, and "t" as above. Each line has as many columns as the header and ends
// with a newline, the last one too, which is cut off otherwise.
//
// Whatever the locale, decimals have a point. Anything else is an error that names the line.
// Thread-safe.
Result<std::vector<Vec3>> read_trajectory(const std::string& path);

}  // namespace palpate
