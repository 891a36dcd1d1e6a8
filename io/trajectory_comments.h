#pragma once

// What the comments before the first position of a trajectory state.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/trajectory_columns.h"

namespace palpate {

// Why a line contradicts another one, or states what is not known.
struct LineProblem {
  std::size_t line = 0;
  std::string problem;
  std::string hint;
};

// Two forms of a comment are applied:
// - a list of columns, as in a header line, with or without a label: "columns: t [ms], x, y, z". It
//   must name as many columns as the lines have.
// - units alone: "units: mm", "length unit = cm", "units are mm, s".
// Every other comment is text. A unit in it is never applied; warnings() names it. Two comments, or
// a comment and a header, that state different things are an error. One thread at a time.
class TrajectoryComments {
 public:
  std::optional<LineProblem> add(std::string_view comment, std::size_t line);

  // For lines without a header: the columns that a comment names, if one does. row_line: the first
  // line of numbers, with row_columns columns.
  std::optional<LineProblem> choose_columns(std::size_t row_columns, std::size_t row_line,
                                            std::optional<TrajectoryColumns>& columns);

  // Gives columns without units the units that comments state. column_line: the line that states
  // the columns.
  std::optional<LineProblem> apply_units(TrajectoryColumns& columns, std::size_t column_line);

  // 0: none.
  std::size_t naming_line() const { return naming_line_; }
  std::size_t unit_line() const { return unit_line_; }
  std::optional<double> rate_Hz() const { return rate_Hz_; }
  std::size_t rate_line() const { return rate_line_; }

  // What comments say that was not applied to these columns; one line of text each.
  std::vector<std::string> warnings(const TrajectoryColumns& columns) const;

 private:
  struct Naming {
    std::size_t line = 0;
    TrajectoryColumns columns;
    bool is_list = false;  // a list of columns, and no sentence that begins like one
  };
  struct Units {
    std::size_t line = 0;
    std::optional<LengthUnit> length;
    std::optional<TimeUnit> time;
  };
  struct Mention {
    std::size_t line = 0;
    std::string unit;
  };

  std::optional<LineProblem> add_naming(std::string_view text, std::size_t line);
  std::optional<LineProblem> add_units(std::string_view text, std::size_t line, bool& are_units);
  void add_mentions(std::string_view text, std::size_t line);

  std::vector<Naming> namings_;
  std::vector<Units> units_;
  Mention length_mention_;  // the first unit in a text
  Mention time_mention_;
  std::string unused_naming_;  // a warning
  std::size_t naming_line_ = 0;
  std::size_t unit_line_ = 0;
  std::optional<double> rate_Hz_;
  std::size_t rate_line_ = 0;
};

// The rate that a comment states, such as "sampled at 500 Hz" or "dt = 0.002 s", in Hz.
std::optional<double> rate_of_comment(std::string_view comment);

}  // namespace palpate
