#pragma once

// Compares what the readers and writers of csv_table.h give with what the old ones give.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "engine/trials/canonical/canonical_rows.h"
#include "engine/trials/sweep/sweep_rows.h"
#include "engine/trials/trials_file.h"
#include "tests/engine/trials/old/old_canonical_rows.h"
#include "tests/engine/trials/old/old_sweep_rows.h"
#include "tests/engine/trials/old/old_trials_file.h"

namespace palpate::tables {

// The bits of a value, so that nan equals nan and 0 differs from -0.
inline std::uint64_t bits(double value) {
  return std::bit_cast<std::uint64_t>(value);
}
inline std::vector<std::uint64_t> bits(const std::optional<double>& value) {
  return value ? std::vector{bits(*value)} : std::vector<std::uint64_t>{};
}
template <std::size_t count>
std::vector<std::vector<std::uint64_t>> bits(
    const std::array<std::optional<double>, count>& values) {
  std::vector<std::vector<std::uint64_t>> all;
  for (const auto& value : values) all.push_back(bits(value));
  return all;
}

inline auto members(const TrialRow& r) {
  return std::tuple(r.following, r.participant, r.block, r.trial, r.haptic, r.rotation, r.object,
                    r.attempt, r.status, bits(r.measures), r.strategy, r.view, r.align,
                    bits(r.start_orientation_deg), bits(r.scale));
}
inline auto members(const SweepRow& r) {
  return std::tuple(r.point, r.block, r.varied, bits(r.values), r.participant, r.haptic, r.rotation,
                    r.trials, r.done, r.timeouts, r.faults, bits(r.limit_s), bits(r.means));
}
inline auto members(const CanonicalRow& r) {
  return std::tuple(r.participant, bits(r.cell.angle_deg), r.cell.motion, r.cell.rotates,
                    bits(r.along_over_into), bits(r.share_within_30deg));
}

struct TrialsKind {
  static auto parse(const std::string& text, const std::string& path = "t.csv") {
    return parse_trials(text, path);
  }
  static auto old_parse(const std::string& text, const std::string& path = "t.csv") {
    return old::parse_trials(text, path);
  }
  static void write(CsvLines& lines, const TrialRow& row) { add_row(lines, row); }
  static void old_write(CsvLines& lines, const TrialRow& row) { old::add_row(lines, row); }
};
struct SweepKind {
  static auto parse(const std::string& text, const std::string& path = "t.csv") {
    return parse_sweep_rows(text, path);
  }
  static auto old_parse(const std::string& text, const std::string& path = "t.csv") {
    return old::parse_sweep_rows(text, path);
  }
  static void write(CsvLines& lines, const SweepRow& row) { add_sweep_row(lines, row); }
  static void old_write(CsvLines& lines, const SweepRow& row) { old::add_sweep_row(lines, row); }
};
struct CanonicalKind {
  static auto parse(const std::string& text, const std::string& path = "t.csv") {
    return parse_canonical_rows(text, path);
  }
  static auto old_parse(const std::string& text, const std::string& path = "t.csv") {
    return old::parse_canonical_rows(text, path);
  }
  static void write(CsvLines& lines, const CanonicalRow& row) { add_canonical_row(lines, row); }
  static void old_write(CsvLines& lines, const CanonicalRow& row) {
    old::add_canonical_row(lines, row);
  }
};

struct Counts {
  std::size_t texts = 0, read = 0, refused = 0, rows = 0;
  std::map<std::string, std::size_t> problems;
};

// The problem without what was found in the file.
inline std::string kind_of(const Error& error) {
  const std::size_t expected = error.problem.find("; expected");
  const std::size_t column = error.element.find(", column ");
  return (column == std::string::npos ? "line" : error.element.substr(column + 9)) + ": " +
         (expected == std::string::npos ? error.problem : error.problem.substr(expected + 2));
}

template <class Kind>
void compare(const std::string& text, Counts& counts) {
  const auto now = Kind::parse(text);
  const auto before = Kind::old_parse(text);
  ++counts.texts;
  ASSERT_EQ(now.ok(), before.ok()) << (now.ok() ? before.error() : now.error()).to_string() << "\n"
                                   << text;
  if (!now.ok()) {
    ++counts.refused;
    ++counts.problems[kind_of(now.error())];
    ASSERT_EQ(now.error().code, before.error().code) << text;
    ASSERT_EQ(now.error().path, before.error().path) << text;
    ASSERT_EQ(now.error().element, before.error().element) << text;
    ASSERT_EQ(now.error().problem, before.error().problem) << text;
    ASSERT_EQ(now.error().hint, before.error().hint) << text;
    return;
  }
  ++counts.read;
  counts.rows += now->size();
  ASSERT_EQ(now->size(), before->size());
  CsvLines lines(""), old_lines("");
  for (std::size_t i = 0; i < now->size(); ++i) {
    ASSERT_EQ(members((*now)[i]), members((*before)[i])) << text;
    Kind::write(lines, (*now)[i]);
    Kind::old_write(old_lines, (*before)[i]);
  }
  ASSERT_EQ(lines.text(), old_lines.text());
}

inline void print(const char* name, const Counts& counts) {
  std::cout << name << ": " << counts.texts << " texts, " << counts.read << " read with "
            << counts.rows << " rows, " << counts.refused << " refused with "
            << counts.problems.size() << " kinds of messages\n";
}

// parse_trials() and the like, compared: for the tests of broken inputs.
template <class Kind>
auto compared(const std::string& text, const std::string& path) {
  static Counts counts;
  compare<Kind>(text, counts);
  print("so far", counts);
  return Kind::parse(text, path);
}
inline auto compared_trials(const std::string& text, const std::string& path) {
  return compared<TrialsKind>(text, path);
}
inline auto compared_sweep(const std::string& text, const std::string& path) {
  return compared<SweepKind>(text, path);
}
inline auto compared_canonical(const std::string& text, const std::string& path) {
  return compared<CanonicalKind>(text, path);
}

}  // namespace palpate::tables
