#include "engine/analysis/power_design.h"

#include <cmath>
#include <limits>
#include <utility>

#include "engine/analysis/repeated_measures.h"

namespace palpate {
namespace {

// Collects the tests and the columns of their weights.
class PowerTestList {
 public:
  explicit PowerTestList(const PowerDesign& design)
      : haptics_(static_cast<Eigen::Index>(design.haptic.size())),
        rotations_(static_cast<Eigen::Index>(design.rotation.size())) {}

  Eigen::Index haptics() const { return haptics_; }
  Eigen::Index rotations() const { return rotations_; }

  // weights: of the levels of Haptic and of the levels of Rotation, as columns.
  void add_effect(const FactorSet& term, const Eigen::MatrixXd& haptic,
                  const Eigen::MatrixXd& rotation) {
    const std::size_t first = columns_.size();
    for (Eigen::Index h = 0; h < haptic.cols(); ++h) {
      for (Eigen::Index r = 0; r < rotation.cols(); ++r) {
        add_column(haptic.col(h), rotation.col(r));
      }
    }
    const std::size_t scores = columns_.size() - first;
    put({effect_name(term), "", PowerCorrection::kNone, first, scores});
    if (scores > 1) {
      put({effect_name(term), "", PowerCorrection::kGreenhouseGeisser, first, scores});
    }
  }

  void add_pair(std::string name, std::string family, const Eigen::VectorXd& haptic,
                const Eigen::VectorXd& rotation) {
    put({std::move(name), std::move(family), PowerCorrection::kHolm, columns_.size(), 1});
    add_column(haptic, rotation);
  }

  PowerTests finished() {
    PowerTests all{std::move(tests_), Eigen::MatrixXd(haptics_ * rotations_, columns_.size())};
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      all.weights.col(static_cast<Eigen::Index>(i)) = columns_[i];
    }
    return all;
  }

 private:
  void put(PowerTest test) { tests_.push_back(std::move(test)); }

  void add_column(const Eigen::VectorXd& haptic, const Eigen::VectorXd& rotation) {
    Eigen::VectorXd column(haptics_ * rotations_);
    for (Eigen::Index h = 0; h < haptics_; ++h) {
      column.segment(h * rotations_, rotations_) = haptic(h) * rotation;
    }
    columns_.push_back(std::move(column));
  }

  Eigen::Index haptics_, rotations_;
  std::vector<PowerTest> tests_;
  std::vector<Eigen::VectorXd> columns_;
};

// The mean over all levels, of length 1 as a vector of weights.
Eigen::MatrixXd unit_mean(Eigen::Index levels) {
  return Eigen::MatrixXd::Constant(levels, 1, 1.0 / std::sqrt(static_cast<double>(levels)));
}

void add_effects(PowerTestList& list) {
  const Eigen::MatrixXd haptic = helmert_contrasts(static_cast<int>(list.haptics()));
  const Eigen::MatrixXd rotation = helmert_contrasts(static_cast<int>(list.rotations()));
  if (list.haptics() > 1) {
    list.add_effect({kHapticFactor}, haptic, unit_mean(list.rotations()));
  }
  if (list.rotations() > 1) {
    list.add_effect({kRotationFactor}, unit_mean(list.haptics()), rotation);
  }
  if (list.haptics() > 1 && list.rotations() > 1) {
    list.add_effect({kHapticFactor, kRotationFactor}, haptic, rotation);
  }
}

// The families of primary_analysis.cpp.
void add_pairs(PowerTestList& list, const PowerDesign& design) {
  using Eigen::VectorXd;
  const Eigen::Index haptics = list.haptics(), rotations = list.rotations();
  const VectorXd mean = VectorXd::Constant(rotations, 1.0 / static_cast<double>(rotations));
  for (Eigen::Index i = 0; i < haptics; ++i) {
    for (Eigen::Index j = i + 1; j < haptics; ++j) {
      list.add_pair(design.haptic[j] + " - " + design.haptic[i], "levels of Haptic",
                    VectorXd::Unit(haptics, j) - VectorXd::Unit(haptics, i), mean);
    }
  }
  if (rotations < 2) return;
  const VectorXd rotation = VectorXd::Unit(rotations, 1) - VectorXd::Unit(rotations, 0);
  for (Eigen::Index h = 0; h < haptics; ++h) {
    list.add_pair("R - NoR in " + design.haptic[h], "R - NoR within each level of Haptic",
                  VectorXd::Unit(haptics, h), rotation);
  }
}

}  // namespace

std::string PowerDesign::condition_name(std::size_t condition) const {
  return haptic[condition / rotation.size()] + "-" + rotation[condition % rotation.size()];
}

PowerDesign power_design_of(Outcome outcome) {
  PowerDesign design{{kHapticNames.begin(), kHapticNames.end()},
                     {kRotationNames.begin(), kRotationNames.end()}};
  if (outcome == Outcome::kContactAngle) design.haptic = {"UaH"};
  return design;
}

bool PowerTests::is_null(const PowerTest& test, const std::vector<double>& means) const {
  const Eigen::Map<const Eigen::VectorXd> at(means.data(), static_cast<Eigen::Index>(means.size()));
  // Each mean may be a sum of three numbers, and a score is a sum of one product per mean.
  const double roundings = static_cast<double>(means.size()) + 4.0;
  const double bound = roundings * std::numeric_limits<double>::epsilon() * at.cwiseAbs().sum();
  const auto first = static_cast<Eigen::Index>(test.first_score);
  const auto scores = static_cast<Eigen::Index>(test.scores);
  return ((weights.middleCols(first, scores).transpose() * at).cwiseAbs().array() <= bound).all();
}

PowerTests power_tests(const PowerDesign& design) {
  PowerTestList list(design);
  add_effects(list);
  add_pairs(list, design);
  return list.finished();
}

}  // namespace palpate
