#pragma once

// Recorded positions of a device, read from a text file.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "geometry/base/result.h"
#include "geometry/base/types.h"

namespace palpate {

struct Trajectory {
  // Device frame, in the file's order; at least one. nan and inf are kept: bad samples.
  std::vector<Vec3> positions_m;
  // The time of each position since the first one, in whole nanoseconds, and its line in the file.
  // Strictly increasing; empty if the file has no times.
  std::vector<std::int64_t> times_ns;
  std::vector<std::size_t> lines;
  bool has_summed_times = false;  // a trace: each time is a sum of time steps in doubles
  // The rate that a comment before the first position states, and the line of the comment. Nothing
  // is done with it.
  std::optional<double> stated_rate_Hz;
  std::size_t stated_rate_line = 0;
  // What was converted, and what was not used: one line of text each.
  std::vector<std::string> notes;
  // What a comment says that was not applied: "line 2, a comment, names mm; ...".
  std::vector<std::string> warnings;
};

// A line contains "x y z" or "t x y z", in metres and seconds, separated by blanks or commas. Every
// line has the same number of columns. "#" begins a comment, empty lines are skipped, and lines end
// with LF, CRLF or CR.
//
// The first line may be a header, which names the columns x, y and z in any order, among any other
// columns, and perhaps a time, each with or without a unit (trajectory_columns.h). Positions and
// times are converted from their units. A position in a power of ten of the metre is rounded once;
// one in in, ft, yd or mil twice, by at most one unit in the last place. A line of units may
// follow. A comment before the first position counts as a header if it is a list of columns, and
// states the units if it consists of them, as "units: mm" (trajectory_comments.h). A unit that is
// not known, or that is stated for some axes only, is an error, and so are two lines that state
// different units.
//
// Times are read from their decimal digits and rounded to whole nanoseconds. They must be finite
// and increase. rate_Hz: the rate at which a column such as "n [samples]" counts; without it such a
// column is an error.
//
// In a table whose columns are separated by semicolons or tabs, and in quotes, commas are decimal
// commas. Elsewhere, a comma that could be either is an error.
//
// A trace (trace_csv.h) is also a trajectory. It is recognised by its columns t and device_x,
// device_y or device_z. Each line of a trace has as many columns as the header and ends with a
// newline; a last line without a newline counts as cut off.
//
// The decimal separator is a point in every locale. Any other content is an error that names the
// line. Thread-safe.
Result<Trajectory> read_trajectory(const std::string& path, std::optional<double> rate_Hz = {});

}  // namespace palpate
