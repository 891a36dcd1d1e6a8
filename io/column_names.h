#pragma once

// The names of the columns of a table of positions, with their units.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_fields.h"

namespace palpate {

// A column's name, divided into its words and its unit: "Pos_X [mm]" has the words "pos" and "x"
// and the unit "mm".
struct ColumnName {
  std::string text;                // as written, without quotes
  std::vector<std::string> words;  // small letters
  std::string unit;                // as written; empty: none is stated
  bool has_unit_in_brackets = false;
};

// A unit may stand in brackets of any kind, also of full width, after "/", or as the last word
// ("x_mm", "x in", "x in mm"). A last word counts as a unit if it is a known one. Thread-safe.
ColumnName read_column_name(std::string_view text);

// The columns of a header line.
std::vector<ColumnName> read_column_names(std::string_view line, Separator separator);

// What a column contains, by its words.
enum class ColumnKind : std::uint8_t { kOther, kPosition, kTime };

struct ColumnMeaning {
  ColumnKind kind = ColumnKind::kOther;
  int axis = -1;       // of kPosition: 0, 1 or 2
  std::string family;  // the other words of a position: "" for "x", "tip" for "tip_x"
};

ColumnMeaning meaning_of(const ColumnName& name);

// True if the words begin with x, y or z, as in "x_raw": perhaps a position.
bool begins_with_axis(const ColumnName& name);

// Characters of full width, blanks of all kinds and micro signs as ASCII.
std::string in_ascii(std::string_view text);

}  // namespace palpate
