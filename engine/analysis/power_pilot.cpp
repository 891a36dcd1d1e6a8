#include "engine/analysis/power_pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include <Eigen/Cholesky>

#include "engine/analysis/statistics_text.h"
#include "engine/trials/strict_json.h"
#include "engine/trials/trials_file.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

constexpr double kNoTrial = std::numeric_limits<double>::quiet_NaN();
// Used only for an outcome that power does not have: the time with timeouts as the limit.
constexpr double kAnyLimit_s = 120.0;
constexpr const char* kPeople = "people";

Error pilot_error(const std::string& path, std::string element, std::string problem,
                  std::string hint) {
  return {ErrorCode::kInvalidContent, path, std::move(element), std::move(problem),
          std::move(hint)};
}

// The trials of one condition: one row per participant, one column per object and block; NaN: none.
// Columns without any trial are left out.
Eigen::MatrixXd condition_trials(const TrialTable& table, Outcome outcome,
                                 const std::vector<int>& participants, int haptic, int rotation) {
  const int objects = table.level_count(kObjectFactor), blocks = table.level_count(kTrialFactor);
  Eigen::MatrixXd trials(participants.size(), objects * blocks);
  Eigen::Index used = 0;
  for (int o = 0; o < objects; ++o) {
    for (int b = 0; b < blocks; ++b) {
      bool has_trial = false;
      for (Eigen::Index p = 0; p < trials.rows(); ++p) {
        const auto value = table.value(participants[static_cast<std::size_t>(p)],
                                       table.condition(haptic, rotation, o), b, outcome);
        trials(p, used) = value.value_or(kNoTrial);
        has_trial = has_trial || value;
      }
      used += has_trial ? 1 : 0;
    }
  }
  return trials.leftCols(used);
}

// Least squares of y = participant + item in one condition, an item being an object and a block.
struct ConditionFit {
  Eigen::VectorXd means;  // of the participants, over all items
  double residual_ss = 0.0;
  int df = 0;
  int trials = 0;
  // The variance of the differences between the means, for e = 1: trace((I - J / n) V), V their
  // covariance and J a matrix of ones.
  double mean_scatter = 0.0;
  double m =
      0.0;  // trials of a participant: complete, their number; otherwise the effective number
};

// Whether every participant is linked to every item by trials; otherwise their means cannot be
// compared. has: 1 for a trial.
bool is_connected(const Eigen::MatrixXd& has) {
  std::vector<bool> rows(static_cast<std::size_t>(has.rows()));
  std::vector<Eigen::Index> open = {0};
  std::vector<bool> columns(static_cast<std::size_t>(has.cols()));
  rows[0] = true;
  while (!open.empty()) {
    const Eigen::Index row = open.back();
    open.pop_back();
    for (Eigen::Index c = 0; c < has.cols(); ++c) {
      if (has(row, c) == 0.0 || columns[static_cast<std::size_t>(c)]) continue;
      columns[static_cast<std::size_t>(c)] = true;
      for (Eigen::Index r = 0; r < has.rows(); ++r) {
        if (has(r, c) == 0.0 || rows[static_cast<std::size_t>(r)]) continue;
        rows[static_cast<std::size_t>(r)] = true;
        open.push_back(r);
      }
    }
  }
  return std::find(rows.begin(), rows.end(), false) == rows.end();
}

// trials: connected. Eliminates the participants: with A the table of what is there, D the numbers
// of a participant's trials, C those of an item's and y-bar the plain means, the items t solve
// S t = sum over p of A (y - y-bar), S = C - A^T D^-1 A, with the sum 0. Then the means are
// y-bar - D^-1 A t, with the covariance D^-1 + D^-1 A S^+ A^T D^-1.
ConditionFit fit_condition(const Eigen::MatrixXd& trials, const Eigen::MatrixXd& has) {
  const auto n = static_cast<double>(trials.rows());
  const Eigen::MatrixXd there = (has.array() > 0.0).select(trials, 0.0);
  const Eigen::VectorXd counts = has.rowwise().sum();
  const Eigen::VectorXd plain = there.rowwise().sum().cwiseQuotient(counts);
  const Eigen::MatrixXd shares = counts.cwiseInverse().asDiagonal() * has;  // D^-1 A
  const Eigen::MatrixXd deviations = has.cwiseProduct(there.colwise() - plain);
  const auto items = trials.cols();
  Eigen::MatrixXd s = -(has.transpose() * shares);
  s.diagonal() += has.colwise().sum().transpose();
  // Of constants, S is 0; on the sums of 0, adding J / items changes nothing.
  const double lift = 1.0 / static_cast<double>(items);
  const Eigen::LDLT<Eigen::MatrixXd> solver(s + Eigen::MatrixXd::Constant(items, items, lift));
  const Eigen::VectorXd of_items = solver.solve(deviations.colwise().sum().transpose());
  ConditionFit fit;
  fit.means = plain - shares * of_items;
  const Eigen::MatrixXd residuals =
      has.cwiseProduct((there.colwise() - fit.means).rowwise() - of_items.transpose());
  fit.residual_ss = residuals.squaredNorm();
  fit.trials = static_cast<int>(has.sum());
  fit.df = fit.trials - static_cast<int>(trials.rows() + items - 1);
  // S^+ on the centred rows of D^-1 A, which sum to 0: the inverse of S + J / items does the same.
  const Eigen::MatrixXd centred = shares.rowwise() - shares.colwise().mean();
  fit.mean_scatter = counts.cwiseInverse().sum() * (1.0 - 1.0 / n) +
                     solver.solve(centred.transpose()).cwiseProduct(centred.transpose()).sum();
  const bool is_complete = fit.trials == has.size();
  fit.m = is_complete ? static_cast<double>(items) : (n - 1.0) / fit.mean_scatter;
  return fit;
}

// Without rounding if all conditions have the same m.
double harmonic_mean_of_m(const std::vector<ConditionFit>& fits) {
  double sum = 0.0;
  bool is_equal = true;
  for (const ConditionFit& fit : fits) {
    sum += 1.0 / fit.m;
    is_equal = is_equal && fit.m == fits.front().m;
  }
  return is_equal ? fits.front().m : static_cast<double>(fits.size()) / sum;
}

class PilotReader {
 public:
  PilotReader(const TrialTable& table, Outcome outcome, const PowerDesign& design,
              const std::string& path)
      : table_(table), outcome_(outcome), design_(design), path_(path) {}

  Result<PilotEstimate> estimate();

 private:
  std::optional<Error> find_levels();
  std::optional<Error> check_values(const Eigen::MatrixXd& trials) const;
  std::optional<Error> find_participants();
  std::optional<Error> fit_conditions();
  std::optional<Error> put_mean_squares();
  void put_variances();
  bool has_condition(int participant, std::size_t condition) const;
  std::pair<int, int> levels_of(std::size_t condition) const {
    return {haptic_[condition / rotation_.size()], rotation_[condition % rotation_.size()]};
  }
  Error error(std::string element, std::string problem, std::string hint) const {
    return pilot_error(path_, std::move(element), std::move(problem), std::move(hint));
  }

  const TrialTable& table_;
  Outcome outcome_;
  const PowerDesign& design_;
  const std::string& path_;
  std::vector<int> haptic_, rotation_;  // places in the table of the levels of the design
  std::vector<int> participants_;
  std::vector<ConditionFit> fits_;
  PilotEstimate found_;
};

std::optional<Error> PilotReader::find_levels() {
  const auto find = [&](ExperimentFactor factor, const std::vector<std::string>& names,
                        std::vector<int>& places) -> std::optional<Error> {
    const auto& levels = table_.levels(factor);
    for (const std::string& name : names) {
      const auto place = std::find(levels.begin(), levels.end(), name);
      if (place == levels.end()) {
        return error(factor == kHapticFactor ? "column haptic" : "column rotation",
                     "has no trial of " + name + " beside practice; expected trials of " +
                         std::to_string(design_.conditions()) + " conditions",
                     "without such a pilot, use --error, --share-u and --share-w");
      }
      places.push_back(static_cast<int>(place - levels.begin()));
    }
    return std::nullopt;
  };
  if (auto missing = find(kHapticFactor, design_.haptic, haptic_)) return missing;
  if (auto missing = find(kRotationFactor, design_.rotation, rotation_)) return missing;
  if (table_.has(outcome_)) return std::nullopt;
  return error("column " + std::string(outcome_text(outcome_).column),
               "has no value in a completed trial; expected the measure of --measure",
               "choose another measure");
}

// So large values would overflow, or hide their scatter.
std::optional<Error> PilotReader::check_values(const Eigen::MatrixXd& trials) const {
  for (Eigen::Index p = 0; p < trials.rows(); ++p) {
    for (Eigen::Index i = 0; i < trials.cols(); ++i) {
      if (!(std::abs(trials(p, i)) > kMostPowerValue)) continue;  // NaN: no trial
      const int participant = participants_[static_cast<std::size_t>(p)];
      return error("column " + std::string(outcome_text(outcome_).column),
                   "is " + number_or_dash(trials(p, i)) + " in a trial of participant " +
                       printable(table_.participants()[static_cast<std::size_t>(participant)]) +
                       ", which is too large; expected -1e9 to 1e9",
                   "check the unit of the column");
    }
  }
  return std::nullopt;
}

bool PilotReader::has_condition(int participant, std::size_t condition) const {
  const auto [haptic, rotation] = levels_of(condition);
  for (int o = 0; o < table_.level_count(kObjectFactor); ++o) {
    for (int b = 0; b < table_.level_count(kTrialFactor); ++b) {
      if (table_.value(participant, table_.condition(haptic, rotation, o), b, outcome_)) {
        return true;
      }
    }
  }
  return false;
}

std::optional<Error> PilotReader::find_participants() {
  std::string lacks;  // of the first who is left out
  for (int p = 0; p < static_cast<int>(table_.participants().size()); ++p) {
    const std::string name = printable(table_.participants()[static_cast<std::size_t>(p)]);
    std::size_t condition = 0;
    while (condition < design_.conditions() && has_condition(p, condition)) ++condition;
    if (condition == design_.conditions()) {
      participants_.push_back(p);
      continue;
    }
    if (lacks.empty()) lacks = name + " lacks " + design_.condition_name(condition);
    found_.left_out.push_back(name);
  }
  found_.participants = static_cast<int>(participants_.size());
  if (found_.participants >= 2) return std::nullopt;
  return error("column participant",
               "has " + std::to_string(found_.participants) +
                   (found_.participants == 1 ? " participant" : " participants") +
                   " with a completed trial in each of " + std::to_string(design_.conditions()) +
                   " conditions (" + lacks + "); expected two or more",
               "add their trials, or use --error, --share-u and --share-w without a pilot");
}

std::optional<Error> PilotReader::fit_conditions() {
  for (std::size_t c = 0; c < design_.conditions(); ++c) {
    const auto [haptic, rotation] = levels_of(c);
    const Eigen::MatrixXd trials =
        condition_trials(table_, outcome_, participants_, haptic, rotation);
    if (auto failed = check_values(trials)) return failed;
    const Eigen::MatrixXd has =
        trials.unaryExpr([](double value) { return std::isnan(value) ? 0.0 : 1.0; });
    if (!is_connected(has)) {
      return error("condition " + design_.condition_name(c),
                   "has participants whose objects and blocks no other participant has; expected "
                   "the same objects and blocks for all",
                   "remove the trials that nobody else did");
    }
    fits_.push_back(fit_condition(trials, has));
    found_.missing += static_cast<int>(trials.rows() * table_.level_count(kObjectFactor) *
                                       table_.level_count(kTrialFactor)) -
                      fits_.back().trials;
  }
  return std::nullopt;
}

std::optional<Error> PilotReader::put_mean_squares() {
  const auto n = static_cast<Eigen::Index>(participants_.size());
  const auto k = static_cast<Eigen::Index>(design_.conditions());
  Eigen::MatrixXd cells(n, k);
  double residual_ss = 0.0;
  for (Eigen::Index c = 0; c < k; ++c) {
    const ConditionFit& fit = fits_[static_cast<std::size_t>(c)];
    cells.col(c) = fit.means;
    residual_ss += fit.residual_ss;
    found_.df_e += fit.df;
    found_.trials += fit.trials;
    found_.means.push_back(fit.means.mean());
  }
  if (found_.df_e == 0) {
    const bool is_single = found_.trials == static_cast<int>(n * k);
    return error("columns object and block",
                 is_single
                     ? "have one trial of a participant in a condition; expected two or more, "
                       "because the scatter of trials cannot be told from that of conditions "
                       "otherwise"
                     : "have so few trials in common that the " + std::to_string(found_.trials) +
                           " trials only fix the means of participants, objects and blocks; "
                           "expected two objects or blocks that the same two participants did in "
                           "one condition",
                 "use --error, --share-u and --share-w without a pilot");
  }
  found_.df_p = static_cast<int>(n - 1);
  found_.df_pc = static_cast<int>((n - 1) * (k - 1));
  found_.m = harmonic_mean_of_m(fits_);
  const Eigen::MatrixXd within = cells.rowwise() - cells.colwise().mean();
  const Eigen::VectorXd of_participants = within.rowwise().mean();
  const Eigen::MatrixXd interaction = within.colwise() - of_participants;
  found_.ms_e = residual_ss / found_.df_e;
  found_.ms_pc = found_.m * interaction.squaredNorm() / found_.df_pc;
  found_.ms_p = found_.m * static_cast<double>(k) * of_participants.squaredNorm() / found_.df_p;
  // Each number is a sum of at most `trials` rounded terms.
  const double rounding = static_cast<double>(found_.trials) *
                          std::numeric_limits<double>::epsilon() * cells.cwiseAbs().maxCoeff();
  if (found_.ms_e > rounding * rounding || found_.ms_pc > found_.m * rounding * rounding) {
    found_.cells = std::move(cells);
    return std::nullopt;
  }
  return error("column " + std::string(outcome_text(outcome_).column),
               "does not vary beside what all participants have in common; expected a measure "
               "with scatter",
               "check the column");
}

void PilotReader::put_variances() {
  const auto k = static_cast<double>(design_.conditions());
  found_.raw = {(found_.ms_p - found_.ms_pc) / (k * found_.m),
                (found_.ms_pc - found_.ms_e) / found_.m, found_.ms_e};
  found_.variances = {std::max(0.0, found_.raw.u), std::max(0.0, found_.raw.w),
                      std::max(0.0, found_.raw.e)};
}

Result<PilotEstimate> PilotReader::estimate() {
  if (auto failed = find_levels()) return *failed;
  if (auto failed = find_participants()) return *failed;
  if (auto failed = fit_conditions()) return *failed;
  if (auto failed = put_mean_squares()) return *failed;
  put_variances();
  return std::move(found_);
}

std::string following_name(const std::string& following) {
  return following.empty() ? kPeople : following;
}

}  // namespace

Result<PilotEstimate> estimate_pilot(const TrialTable& table, Outcome outcome,
                                     const PowerDesign& design, const std::string& path) {
  return PilotReader(table, outcome, design, path).estimate();
}

namespace {

// Removes practice and what the design does not compare.
std::optional<Error> keep_design(std::vector<TrialRow>& rows, const PowerDesign& design,
                                 const std::string& path) {
  std::erase_if(rows, [](const TrialRow& row) { return row.block <= 0; });
  const bool had_rows = !rows.empty();
  std::erase_if(rows, [&](const TrialRow& row) {
    return std::find(design.haptic.begin(), design.haptic.end(), row.haptic) ==
               design.haptic.end() &&
           std::find(kHapticNames.begin(), kHapticNames.end(), row.haptic) != kHapticNames.end();
  });
  if (!rows.empty() || !had_rows) return std::nullopt;
  return pilot_error(path, "column haptic",
                     "has no trial of " +
                         joined_words({design.haptic.begin(), design.haptic.end()}) +
                         " beside practice; expected trials of " +
                         std::to_string(design.conditions()) + " conditions",
                     "the measure needs them; choose another one with --measure");
}

// Each variant is an experiment of its own (trial_variant.h).
std::optional<Error> check_one_variant(const std::vector<TrialRow>& rows, const std::string& path) {
  if (rows.empty()) return std::nullopt;
  const TrialVariant first = variant_of(rows.front());
  for (const TrialRow& row : rows) {
    const TrialVariant other = variant_of(row);
    if (other == first) continue;
    const char* const column = other.view != first.view     ? "view"
                               : other.align != first.align ? "align"
                               : other.scale != first.scale ? "scale"
                                                            : "start_orientation_deg";
    return pilot_error(path, std::string("column ") + column,
                       "has several levels; expected trials of one experiment",
                       "keep the rows of one level in a file of their own");
  }
  return std::nullopt;
}

}  // namespace

Result<TrialTable> read_pilot(const std::string& path, const std::string& following,
                              const PowerDesign& design) {
  auto rows = read_trials(path);
  if (!rows) return rows.error();
  std::set<std::string> names;
  for (const TrialRow& row : *rows) {
    if (!row.strategy.empty()) {
      return pilot_error(path, "column strategy",
                         "is " + row.strategy + " in a trial of participant " +
                             printable(row.participant) +
                             "; expected trials with haptic and rotation",
                         "use the trials of `experiment run` or of people");
    }
    names.insert(following_name(row.following));
  }
  const std::string list = joined_words({names.begin(), names.end()});
  if (following.empty() && names.size() > 1) {
    return pilot_error(
        path, "column following",
        "has trials of " + std::to_string(names.size()) + " kinds; expected one kind",
        "choose one with --following: " + list);
  }
  if (!following.empty() && !names.contains(following)) {
    return invalid_argument("--following", "is \"" + printable(following) + "\"; expected " + list,
                            "these are in " + printable(path));
  }
  if (!following.empty()) {
    std::erase_if(*rows,
                  [&](const TrialRow& row) { return following_name(row.following) != following; });
  }
  if (auto error = keep_design(*rows, design, path)) return *error;
  if (auto error = check_one_variant(*rows, path)) return *error;
  auto table = TrialTable::create(std::move(*rows), kAnyLimit_s);
  if (table) return table;
  Error error = table.error();
  error.path = path;
  return error;
}

}  // namespace palpate
