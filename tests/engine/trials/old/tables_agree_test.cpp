// Compares the readers and writers that follow from csv_table.h with those that were written by
// hand: row by row and message for message.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/trials/csv_reader.h"
#include "engine/trials/levels.h"
#include "tests/engine/trials/old/compare_tables.h"
#include "tests/helpers/random.h"
#include "tests/helpers/soak.h"

namespace palpate {
namespace {

using tables::CanonicalKind;
using tables::compare;
using tables::Counts;
using tables::print;
using tables::SweepKind;
using tables::TrialsKind;

using Fields = std::vector<std::string>;
using Table = std::vector<Fields>;

template <class T>
const T& one_of(SeededRandom& random, const std::vector<T>& all) {
  return all[random.index(all.size())];
}

std::string number(SeededRandom& random) {
  CsvLines line("");
  line.clear();
  line.add(std::ldexp(random.uniform(0.0, 1.0), static_cast<int>(random.index(40)) - 20))
      .end_line();
  return line.text().substr(0, line.text().size() - 1);
}

Fields names_of_line(const std::string& text) {
  Fields fields;
  CsvReader reader(text);
  EXPECT_TRUE(reader.next(fields).ok());
  return fields;
}

Table table_of(TrialsKind, SeededRandom& random) {
  const bool has_strategies = random.index(2) == 0;
  Table table{names_of_line(
      old::trials_columns(has_strategies ? TrialColumns::kStrategies : TrialColumns::kFactors))};
  const bool is_person = random.index(3) == 0;
  const std::size_t rows = 1 + random.index(4);
  for (std::size_t r = 0; r < rows; ++r) {
    Fields& row = table.emplace_back();
    const auto following = kFollowingLevels[random.index(7)];
    const std::string status = one_of<std::string>(random, {"done", "done", "timeout", "fault"});
    row = {is_person ? "" : std::string(following.name),
           is_person ? "Ann" : std::to_string(1 + random.index(3)),
           std::to_string(random.index(3)),
           std::to_string(1 + random.index(30)),
           has_strategies ? "" : one_of<std::string>(random, {"NoH", "UaH", "H"}),
           has_strategies ? "" : one_of<std::string>(random, {"NoR", "R"}),
           one_of<std::string>(random, {"O1", "O2", "star"}),
           std::to_string(1 + random.index(2)),
           status};
    while (row.size() + 4 + (has_strategies ? 1 : 0) < table[0].size()) {
      row.push_back(random.index(4) == 0 ? "" : number(random));
    }
    if (has_strategies) {
      row.push_back(one_of<std::string>(
          random, {"none", "mask", "full", "a4", "a4-anticipate", "cd", "anisotropic:0.0625"}));
    }
    const bool is_still = !is_person && view_of(following.value) == View::kStill;
    row.push_back(is_still ? "still" : "turning");
    row.push_back(one_of<std::string>(random, {"nearest", "forward"}));
    row.push_back(one_of<std::string>(random, {"0", "-144", "22.5"}));
    row.push_back(one_of<std::string>(random, {"1", "0.1", "2"}));
  }
  // A file of people may have other columns and another order.
  for (int n = static_cast<int>(random.index(4)); n > 0; --n) {
    const std::size_t out = random.index(table[0].size());
    for (Fields& row : table) row.erase(row.begin() + static_cast<std::ptrdiff_t>(out));
  }
  return table;
}

Table table_of(SweepKind, SeededRandom& random) {
  Table table{names_of_line(old::sweep_columns())};
  const std::size_t rows = random.index(4);
  for (std::size_t r = 0; r < rows; ++r) {
    Fields& row = table.emplace_back();
    row = {std::to_string(1 + random.index(9)),
           one_of<std::string>(random, {"base", "one_at_a_time", "hypercube"}),
           one_of<std::string>(random, {"", "speed_m_per_s", "following", "scale"})};
    for (const SweepParameter& parameter : sweep_parameters()) {
      if (random.index(4) == 0) {
        row.emplace_back();
      } else if (parameter.words.empty()) {
        row.push_back(number(random));
      } else {
        row.emplace_back(parameter.words[random.index(parameter.words.size())]);
      }
    }
    row.push_back(std::to_string(1 + random.index(9)));
    row.push_back(one_of<std::string>(random, {"NoH", "UaH", "H"}));
    row.push_back(one_of<std::string>(random, {"NoR", "R"}));
    for (int i = 0; i < 4; ++i) row.push_back(std::to_string(random.index(9)));
    row.push_back(number(random));
    while (row.size() < table[0].size()) {
      row.push_back(random.index(4) == 0 ? "" : number(random));
    }
  }
  return table;
}

Table table_of(CanonicalKind, SeededRandom& random) {
  Table table{names_of_line(old::canonical_columns())};
  const std::size_t rows = random.index(4);
  for (std::size_t r = 0; r < rows; ++r) {
    table.push_back({std::to_string(1 + random.index(9)),
                     one_of<std::string>(random, {"0", "15", "22.5", "90"}),
                     one_of<std::string>(random, {"pressed", "stroked"}),
                     one_of<std::string>(random, {"NoR", "R"}),
                     random.index(4) == 0 ? "" : number(random),
                     random.index(4) == 0 ? "" : number(random)});
  }
  return table;
}

const std::vector<std::string>& odd_fields() {
  static const std::vector<std::string> fields = {"",
                                                  "NA",
                                                  "na",
                                                  "nan",
                                                  "NaN",
                                                  "-nan",
                                                  "inf",
                                                  "-inf",
                                                  "Infinity",
                                                  "1e999",
                                                  "-1e999",
                                                  "1e-999",
                                                  "-0",
                                                  "0",
                                                  "-1",
                                                  "+1",
                                                  "01",
                                                  "1.5",
                                                  "0x10",
                                                  " 1",
                                                  "1 ",
                                                  "1e3",
                                                  ".5",
                                                  "5.",
                                                  "1e",
                                                  "-1e-300",
                                                  "1000000",
                                                  "1000001",
                                                  "1e9",
                                                  "1000000001",
                                                  "2147483647",
                                                  "2147483648",
                                                  "-2147483648",
                                                  "99999999999999999999",
                                                  "360",
                                                  "-360",
                                                  "360.5",
                                                  "1e6",
                                                  "1000000.5",
                                                  "0.25",
                                                  "NoH",
                                                  "UaH",
                                                  "H",
                                                  "noh",
                                                  "NoR",
                                                  "R",
                                                  "A4",
                                                  "done",
                                                  "timeout",
                                                  "fault",
                                                  "ok",
                                                  "turning",
                                                  "still",
                                                  "nearest",
                                                  "forward",
                                                  "delayed",
                                                  "predict",
                                                  "replan",
                                                  "frozen",
                                                  "adapts-0",
                                                  "adapts-0.5",
                                                  "adapts-1",
                                                  "base",
                                                  "one_at_a_time",
                                                  "hypercube",
                                                  "bass",
                                                  "pressed",
                                                  "stroked",
                                                  "pushed",
                                                  "none",
                                                  "mask",
                                                  "a4",
                                                  "cd",
                                                  "anisotropic",
                                                  "anisotropic:2",
                                                  "anisotropic:2.0",
                                                  "anisotropic:0.0625",
                                                  "anisotropic:99",
                                                  "Ann",
                                                  "Ann ",
                                                  " Ann",
                                                  "A,n",
                                                  "A\"n",
                                                  "A\nn",
                                                  "A\r\nn",
                                                  "A\rn",
                                                  "\x1b[2J",
                                                  "Ren\xE9",
                                                  "Ren\xC3\xA9",
                                                  "\xE2\x80\xAE",
                                                  std::string(100, 'x'),
                                                  std::string(101, 'x'),
                                                  std::string(130, 'y'),
                                                  std::string(1, '\0'),
                                                  "speed_m_per_s",
                                                  "following",
                                                  "participant",
                                                  "total_time_s",
                                                  "haptic",
                                                  "strategy",
                                                  "view",
                                                  "note"};
  return fields;
}

std::string text_of(const Table& table, SeededRandom& random) {
  const bool has_crlf = random.index(8) == 0;
  const std::size_t quoted = random.index(3) == 0 ? 4 : 1000;  // one in how many fields
  std::string text = random.index(12) == 0 ? "\xEF\xBB\xBF" : "";
  for (const Fields& row : table) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i > 0) text += ',';
      const bool needs = row[i].find_first_of(",\"\r\n") != std::string::npos;
      if ((needs && random.index(8) != 0) || random.index(quoted) == 0) {
        text += '"';
        for (const char c : row[i]) text += c == '"' ? "\"\"" : std::string(1, c);
        text += '"';
      } else {
        text += row[i];
      }
    }
    text += has_crlf ? "\r\n" : "\n";
    if (random.index(40) == 0) text += "\n";
  }
  if (random.index(10) == 0 && !text.empty()) text.pop_back();
  return text;
}

void change_fields(Table& table, SeededRandom& random) {
  Fields& row = table[random.index(table.size())];
  if (row.empty() || table[0].empty()) return;
  const std::size_t a = random.index(table[0].size()), b = random.index(table[0].size());
  const auto at = [](Fields& of, std::size_t place) {
    return of.begin() + static_cast<std::ptrdiff_t>(std::min(place, of.size() - 1));
  };
  switch (random.index(10)) {
    case 0:  // two columns, in all lines
      for (Fields& each : table) {
        if (!each.empty()) std::iter_swap(at(each, a), at(each, b));
      }
      break;
    case 1:  // two fields of a line
      std::iter_swap(at(row, a), at(row, b));
      break;
    case 2:
      row.erase(at(row, a));
      break;
    case 3:
      row.insert(at(row, a), one_of(random, odd_fields()));
      break;
    case 4:  // a column
      for (Fields& each : table) {
        if (!each.empty()) each.erase(at(each, a));
      }
      break;
    case 5:  // another column
      for (Fields& each : table) {
        if (!each.empty()) each.insert(at(each, a), one_of(random, odd_fields()));
      }
      break;
    case 6:
      table.push_back(row);
      break;
    case 7:
      table.erase(table.begin() + static_cast<std::ptrdiff_t>(random.index(table.size())));
      if (table.empty()) table.emplace_back();
      break;
    default:
      Fields& changed =
          table[table.size() > 1 && random.index(8) != 0 ? 1 + random.index(table.size() - 1) : 0];
      if (!changed.empty()) *at(changed, a) = one_of(random, odd_fields());
  }
}

void change_bytes(std::string& text, SeededRandom& random) {
  if (text.empty()) return;
  const std::size_t at = random.index(text.size());
  constexpr std::string_view kBytes = ",\"\n\r;0159.-+eNnaif \t\xEF\xBB\xBF\xE9";
  const char byte = random.index(5) == 0 ? static_cast<char>(random.index(256))
                                         : kBytes[random.index(kBytes.size())];
  switch (random.index(5)) {
    case 0:
      text.erase(at, 1 + random.index(3));
      break;
    case 1:
      text.insert(at, 1, byte);
      break;
    case 2:
      text.resize(at);
      break;
    case 3:
      std::swap(text[at], text[random.index(text.size())]);
      break;
    default:
      text[at] = byte;
  }
}

template <class Kind>
void compare_mutated(const char* name) {
  test::Random random(47);
  const auto count = static_cast<std::size_t>(test::from_environment("PALPATE_MUTATIONS", 10'000));
  Counts counts;
  for (std::size_t n = 0; n < count; ++n) {
    Table table = table_of(Kind(), random);
    for (std::size_t i = random.index(4); i > 0; --i) change_fields(table, random);
    std::string text = text_of(table, random);
    if (random.index(2) == 0) {
      for (std::size_t i = random.index(4); i > 0; --i) change_bytes(text, random);
    }
    compare<Kind>(text, counts);
    if (testing::Test::HasFatalFailure()) return;
  }
  std::cout << "seed " << random.seed() << ", ";
  print(name, counts);
  EXPECT_GE(counts.read, count / 20);
  EXPECT_GE(counts.refused, count / 3);
}

TEST(TablesAgree, OnMutatedTrials) {
  compare_mutated<TrialsKind>("trials.csv");
}
TEST(TablesAgree, OnMutatedSweeps) {
  compare_mutated<SweepKind>("sweep.csv");
}
TEST(TablesAgree, OnMutatedCanonicalTables) {
  compare_mutated<CanonicalKind>("canonical.csv");
}

// A whole table, in which only the bound on the number of rows is broken.
TEST(TablesAgree, OnATableWithTooManyTrials) {
  std::string text = "participant,block,haptic,rotation,object,status\n";
  for (std::size_t i = 0; i <= kMostTrialRows; ++i) {
    text += "P" + std::to_string(i) + ",1,H,R,O1,done\n";
  }
  Counts counts;
  compare<TrialsKind>(text, counts);
  EXPECT_EQ(counts.refused, 1u);
}

TEST(TablesAgree, OnTheNamesAndMeaningsOfColumns) {
  for (const TrialColumns columns : {TrialColumns::kFactors, TrialColumns::kStrategies}) {
    EXPECT_EQ(trials_columns(columns), old::trials_columns(columns));
    EXPECT_EQ(columns_csv(columns), old::columns_csv(columns));
  }
  EXPECT_EQ(sweep_columns(), old::sweep_columns());
  EXPECT_EQ(canonical_columns(), old::canonical_columns());
  EXPECT_EQ(canonical_columns_csv(), old::canonical_columns_csv());
  for (std::size_t i = 0; i < kMeasureCount; ++i) {
    EXPECT_EQ(measure_names()[i], old::trial_measures()[i].name);
  }
}

// All tables of the project and, if PALPATE_TABLES names a folder, its files.
TEST(TablesAgree, OnEveryFile) {
  namespace fs = std::filesystem;
  std::vector<fs::path> folders{PALPATE_SOURCE_DIR "/benchmarks", PALPATE_SOURCE_DIR "/tests",
                                PALPATE_SOURCE_DIR "/models"};
  if (const char* more = std::getenv("PALPATE_TABLES")) folders.emplace_back(more);
  Counts trials, sweeps, canonical;
  for (const fs::path& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".csv") continue;
      std::ifstream file(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      compare<TrialsKind>(text, trials);
      compare<SweepKind>(text, sweeps);
      compare<CanonicalKind>(text, canonical);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GE(trials.texts, 10u);
  print("trials.csv", trials);
  print("sweep.csv", sweeps);
  print("canonical.csv", canonical);
}

}  // namespace
}  // namespace palpate
