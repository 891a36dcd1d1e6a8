#pragma once

// Which columns of a table are the time and the position of a device, and in which units.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/measuring_units.h"
#include "io/text_fields.h"

namespace palpate {

struct TrajectoryColumns {
  Separator separator = Separator::kBlankOrComma;
  std::size_t count = 0;
  std::array<std::size_t, 3> position{};  // x, y, z
  std::optional<std::size_t> time;
  std::array<LengthUnit, 3> length = {kMetre, kMetre, kMetre};
  bool states_length = false;  // of each axis
  TimeUnit time_unit = kSecond;
  bool states_time_unit = false;
  bool counts_samples = false;  // the time column counts samples
  bool is_trace = false;
  std::vector<std::string> unused;  // names of the other columns

  bool is_in_order() const {
    return position[0] < position[1] && position[1] < position[2] && (!time || *time < position[0]);
  }
};

// The columns, or the reason why a line is no header of positions. Thread-safe.
struct HeaderReading {
  std::optional<TrajectoryColumns> columns;
  std::string problem;  // "is the header ...; expected ..."
  std::string hint;
  bool names_positions = false;  // x, y and z, with whatever units
};

// The header of a table: x, y and z, in any order and among any other columns, with or without
// units, and with or without a time. Units must be known, and stated for all of x, y and z or for
// none.
HeaderReading read_header(std::string_view line);

// The same for names that are those of no trace. problem: the part after "is the header ...,
// which".
HeaderReading read_named_columns(std::string_view line);

// The columns of a table without a header: x y z or t x y z.
TrajectoryColumns columns_without_header(bool has_time);

}  // namespace palpate
