#include "engine/analysis/trial_table.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "engine/trials/levels.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

bool is_digit(char c) {
  return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

// Takes the number at the start of a text, without leading zeros.
std::string_view take_number(std::string_view& text) {
  while (text.size() > 1 && text[0] == '0' && is_digit(text[1])) text.remove_prefix(1);
  std::size_t digits = 0;
  while (digits < text.size() && is_digit(text[digits])) ++digits;
  const std::string_view number = text.substr(0, digits);
  text.remove_prefix(digits);
  return number;
}

// Orders names by the numbers in them: "P2" before "P10".
struct NaturalLess {
  bool operator()(const std::string& a, const std::string& b) const {
    std::string_view left = a, right = b;
    while (!left.empty() && !right.empty()) {
      if (is_digit(left[0]) && is_digit(right[0])) {
        const std::string_view m = take_number(left), n = take_number(right);
        if (m.size() != n.size()) return m.size() < n.size();
        if (m != n) return m < n;
      } else if (left[0] != right[0]) {
        return left[0] < right[0];
      } else {
        left.remove_prefix(1);
        right.remove_prefix(1);
      }
    }
    return left.empty() && right.empty() ? a < b : left.empty();  // "01" and "1" differ
  }
};

constexpr const char* kDividingColumns =
    "each combination of view, align, start_orientation_deg and scale is an experiment of its own: "
    "rename a column that has another meaning";

int place_in(const std::vector<std::string>& names, const std::string& name) {
  return static_cast<int>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string row_name(const TrialRow& row) {
  std::string name = row.following.empty() ? "" : "following " + row.following + ", ";
  const std::string variant = variant_name(variant_of(row));
  if (!variant.empty()) name += variant + ", ";
  return name + "participant " + row.participant + ", block " + std::to_string(row.block) + ", " +
         row.haptic + ", " + row.rotation + ", " + row.object;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// The known levels that occur, in their order. An error for another one.
template <std::size_t count>
Result<std::vector<std::string>> known_levels(std::string_view column,
                                              const std::set<std::string>& found,
                                              const std::array<std::string_view, count>& known) {
  std::vector<std::string> levels;
  for (const std::string_view level : known) {
    if (found.contains(std::string(level))) levels.emplace_back(level);
  }
  if (levels.size() == found.size()) return levels;
  for (const std::string& level : found) {
    if (std::find(levels.begin(), levels.end(), level) != levels.end()) continue;
    return invalid_argument(std::string(column),
                            "is \"" + printable(level) + "\"; expected one of " +
                                joined(std::vector<std::string>(known.begin(), known.end())));
  }
  return levels;
}

}  // namespace

std::string effect_name(const FactorSet& term) {
  std::string name;
  for (auto factor = term.rbegin(); factor != term.rend(); ++factor) {
    name += (name.empty() ? "" : " x ") + std::string(kExperimentFactorNames[*factor]);
  }
  return name;
}

Result<TrialTable> TrialTable::create(std::vector<TrialRow> rows, double limit_s) {
  TrialTable table;
  table.limit_s_ = limit_s;
  table.rows_ = std::move(rows);
  if (!table.rows_.empty()) {
    table.following_ = table.rows_[0].following;
    table.variant_ = variant_of(table.rows_[0]);
  }
  std::erase_if(table.rows_, [](const TrialRow& row) { return row.block <= 0; });
  if (auto error = table.find_levels()) return *error;
  if (auto error = table.arrange()) return *error;
  if (auto error = table.check_conditions()) return *error;
  return table;
}

std::string TrialTable::whose() const {
  const std::string name = variant_name(variant_);
  return (following_.empty() ? "" : "following " + following_ + ", ") +
         (name.empty() ? "" : name + ", ");
}

bool TrialTable::has_completed_trial() const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [](const TrialRow& row) { return row.status == TrialStatus::kDone; });
}

bool TrialTable::has_timeouts() const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [](const TrialRow& row) { return row.status == TrialStatus::kTimeout; });
}

std::optional<Error> TrialTable::find_levels() {
  std::set<std::string> haptic, rotation;
  std::set<std::string, NaturalLess> objects, participants;
  std::set<int> blocks;
  for (const TrialRow& row : rows_) {
    haptic.insert(row.haptic);
    rotation.insert(row.rotation);
    objects.insert(row.object);
    participants.insert(row.participant);
    blocks.insert(row.block);
  }
  auto haptic_levels = known_levels("haptic", haptic, kHapticNames);
  if (!haptic_levels) return haptic_levels.error();
  auto rotation_levels = known_levels("rotation", rotation, kRotationNames);
  if (!rotation_levels) return rotation_levels.error();
  participants_.assign(participants.begin(), participants.end());
  levels_[kHapticFactor] = std::move(*haptic_levels);
  levels_[kRotationFactor] = std::move(*rotation_levels);
  levels_[kObjectFactor].assign(objects.begin(), objects.end());
  for (const int block : blocks) levels_[kTrialFactor].push_back(std::to_string(block));
  const std::string whose = this->whose();
  // The products cannot overflow: the number of rows is limited (kMostTrialRows).
  const std::size_t cells = levels_[kHapticFactor].size() * levels_[kRotationFactor].size() *
                            objects.size() * blocks.size();
  if (cells > kMostCells) {
    return invalid_argument(
        whose + "object and block",
        "have " + std::to_string(objects.size()) + " and " + std::to_string(blocks.size()) +
            " levels, which gives " + std::to_string(cells) + " cells; expected at most " +
            std::to_string(kMostCells) + " combinations of haptic, rotation, object and block",
        "check the columns, or analyse fewer objects or blocks");
  }
  if (participants_.size() >= 2) return std::nullopt;
  return invalid_argument(whose + "participant",
                          "has " + std::to_string(participants_.size()) +
                              (participants_.size() == 1 ? " level" : " levels") +
                              " beside practice; expected two participants or more",
                          "the analysis is about differences between participants");
}

std::optional<Error> TrialTable::arrange() {
  const std::size_t places =
      participants_.size() * static_cast<std::size_t>(conditions()) * levels_[kTrialFactor].size();
  row_of_place_.assign(places, -1);
  for (int i = 0; i < static_cast<int>(rows_.size()); ++i) {
    const TrialRow& row = rows_[i];
    for (std::size_t m = 0; m < kMeasureCount; ++m) {
      if (row.status != TrialStatus::kDone || !row.measures[m]) continue;
      if (std::isfinite(*row.measures[m])) continue;
      return invalid_argument(row_name(row) + ", " + std::string(measure_names()[m]),
                              "is not finite; expected a number, because the status is done");
    }
    const int at_condition = condition(place_in(levels_[kHapticFactor], row.haptic),
                                       place_in(levels_[kRotationFactor], row.rotation),
                                       place_in(levels_[kObjectFactor], row.object));
    int& found = row_of_place_[place(place_in(participants_, row.participant), at_condition,
                                     place_in(levels_[kTrialFactor], std::to_string(row.block)))];
    if (found < 0) {
      found = i;
      continue;
    }
    if (rows_[found].attempt == row.attempt) {
      return invalid_argument(row_name(row), "is there twice; expected one row",
                              "remove one row, or number the attempts");
    }
    ++earlier_attempts_;
    if (rows_[found].attempt < row.attempt) found = i;
  }
  return std::nullopt;
}

std::optional<Error> TrialTable::check_conditions() const {
  for (int c = 0; c < conditions(); ++c) {
    bool has_row = false;
    for (int p = 0; p < static_cast<int>(participants_.size()) && !has_row; ++p) {
      for (int t = 0; t < level_count(kTrialFactor); ++t) has_row = has_row || row(p, c, t);
    }
    if (has_row) continue;
    return invalid_argument(whose() + "condition " + condition_name(c),
                            "has no trial; expected every combination of haptic, rotation and "
                            "object",
                            "add its trials, or remove the level that was not tested everywhere");
  }
  return std::nullopt;
}

int TrialTable::level_in(int condition, ExperimentFactor factor) const {
  const int objects = level_count(kObjectFactor), rotations = level_count(kRotationFactor);
  if (factor == kObjectFactor) return condition % objects;
  if (factor == kRotationFactor) return condition / objects % rotations;
  return condition / objects / rotations;
}

std::string TrialTable::condition_name(int condition) const {
  return levels_[kHapticFactor][level_in(condition, kHapticFactor)] + ", " +
         levels_[kRotationFactor][level_in(condition, kRotationFactor)] + ", " +
         levels_[kObjectFactor][level_in(condition, kObjectFactor)];
}

std::size_t TrialTable::place(int participant, int condition, int trial) const {
  return (static_cast<std::size_t>(participant) * static_cast<std::size_t>(conditions()) +
          static_cast<std::size_t>(condition)) *
             levels_[kTrialFactor].size() +
         static_cast<std::size_t>(trial);
}

const TrialRow* TrialTable::row(int participant, int condition, int trial) const {
  const int found = row_of_place_[place(participant, condition, trial)];
  return found < 0 ? nullptr : &rows_[static_cast<std::size_t>(found)];
}

std::optional<double> TrialTable::value(int participant, int condition, int trial,
                                        Outcome outcome) const {
  const TrialRow* found = row(participant, condition, trial);
  return found ? outcome_of(*found, outcome, limit_s_) : std::nullopt;
}

bool TrialTable::has(Outcome outcome) const {
  return std::any_of(rows_.begin(), rows_.end(), [&](const TrialRow& row) {
    return outcome_of(row, outcome, limit_s_).has_value();
  });
}

Result<std::vector<TrialTable>> trial_tables(std::vector<TrialRow> rows, double limit_s) {
  std::vector<std::string> followings;
  for (const std::string_view name : kFollowingNames) followings.emplace_back(name);
  followings.emplace_back();
  std::map<std::pair<TrialVariant, std::size_t>, std::vector<TrialRow>> rows_of;
  for (TrialRow& row : rows) {
    const auto following = std::find(followings.begin(), followings.end(), row.following);
    if (following == followings.end()) {
      std::vector<std::string> known(followings.begin(), followings.end() - 1);
      return invalid_argument("following", "is \"" + printable(row.following) +
                                               "\"; expected one of " + joined(known) +
                                               ", or nothing for people");
    }
    const auto place = static_cast<std::size_t>(following - followings.begin());
    rows_of[{variant_of(row), place}].push_back(std::move(row));
  }
  if (rows_of.size() > kMostTables) {
    return invalid_argument("view, align, start_orientation_deg, scale and following",
                            "divide the file into " + std::to_string(rows_of.size()) +
                                " experiments; expected at most " + std::to_string(kMostTables),
                            kDividingColumns);
  }
  std::vector<TrialTable> tables;
  for (auto& [whose, its_rows] : rows_of) {
    auto table = TrialTable::create(std::move(its_rows), limit_s);
    if (!table) {
      Error error = table.error();
      const bool is_divided = !(rows_of.begin()->first.first == rows_of.rbegin()->first.first);
      if (is_divided)
        error.hint += (error.hint.empty() ? "" : "; ") + std::string(kDividingColumns);
      return error;
    }
    tables.push_back(std::move(*table));
  }
  if (tables.empty()) {
    return invalid_argument("rows", "are 0; expected trials of two participants or more");
  }
  return tables;
}

}  // namespace palpate
