// The page of the canonical protocol, made of given rows.

#include "engine/analysis/canonical_report.h"

#include <cmath>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "engine/analysis/canonical_means.h"
#include "engine/analysis/canonical_plot.h"

namespace palpate {
namespace {

using Value = std::optional<double>;

// The rows of this many operators at one angle: each motion without and with rotation, with the
// same values.
std::vector<CanonicalRow> rows_at(double angle_deg, int operators, Value ratio, Value share) {
  std::vector<CanonicalRow> rows;
  for (int operator_number = 1; operator_number <= operators; ++operator_number) {
    for (const CanonicalMotion motion : {CanonicalMotion::kPressed, CanonicalMotion::kStroked}) {
      for (const bool rotates : {false, true}) {
        rows.push_back({operator_number, {angle_deg, motion, rotates}, ratio, share});
      }
    }
  }
  return rows;
}

std::string page_of(const std::vector<CanonicalRow>& rows, int operators,
                    std::vector<std::string>& warnings) {
  return canonical_report_html(rows, {"plan", 1, operators, "person"}, warnings);
}

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

TEST(CanonicalReport, StatesHowManyOperatorsHaveAValueWhereNotAllHave) {
  std::vector<CanonicalRow> rows = rows_at(30.0, 4, 0.5, 0.25);
  std::vector<std::string> warnings;
  EXPECT_EQ(count_of(page_of(rows, 4, warnings), "n = "), 0u);
  rows.back().along_over_into.reset();  // operator 4, stroked, with rotation
  const std::string page = page_of(rows, 4, warnings);
  EXPECT_EQ(count_of(page, "n = 3<"), 1u);
  EXPECT_EQ(count_of(page, "n = "), 1u);
}

TEST(CanonicalReport, HasOneWarningForOneCause) {
  std::vector<std::string> warnings;
  const std::string untouched = page_of(rows_at(30.0, 2, {}, {}), 2, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("no trial touched the wall")) << warnings[0];
  EXPECT_EQ(count_of(untouched, "<svg "), 0u);
  warnings.clear();
  page_of(rows_at(30.0, 2, {}, 0.5), 2, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(warnings[0].starts_with("no trial has a force into the hand")) << warnings[0];
}

// NoR is tan 89.99 deg. Only an axis in thousands has labels in thousands.
TEST(CanonicalPlot, TheAxisOfTheRatioEndsAboveRAndNotAboveNoR) {
  for (const auto& [with, is_cut] : {std::pair(0.25, true), std::pair(7000.0, false)}) {
    std::vector<CanonicalRow> rows = rows_at(89.99, 2, 5729.6, 0.0);
    for (CanonicalRow& row : rows) {
      if (row.cell.rotates) row.along_over_into = with;
    }
    EXPECT_EQ(is_canonical_ratio_cut(rows, CanonicalMotion::kPressed), is_cut);
    const auto svg =
        canonical_svg(rows, CanonicalMeasure::kAlongOverInto, CanonicalMotion::kPressed);
    ASSERT_TRUE(svg.ok()) << svg.error().to_string();
    const bool has_thousands = std::regex_search(*svg, std::regex(">\\s*[1-9]000\\s*<"));
    EXPECT_EQ(has_thousands, !is_cut);
  }
}

// Student's t for 2 degrees of freedom is 4.302653 at 95 %.
CanonicalRow row_of(int participant, double angle_deg, std::optional<double> ratio) {
  return {participant, {angle_deg, CanonicalMotion::kStroked, true}, ratio, 0.25};
}

TEST(CanonicalMeans, AreThoseOfTheParticipantsWithAValue) {
  const std::vector<CanonicalRow> rows = {row_of(1, 30.0, 1.0), row_of(2, 30.0, 2.0),
                                          row_of(3, 30.0, {}),  row_of(4, 30.0, 3.0),
                                          row_of(1, 15.0, {}),  row_of(2, 15.0, {})};
  const auto means =
      canonical_means(rows, CanonicalMeasure::kAlongOverInto, CanonicalMotion::kStroked, true);
  ASSERT_EQ(means.size(), 2u);
  EXPECT_EQ(means[0].cell.angle_deg, 15.0);
  EXPECT_EQ(means[0].interval.count, 0);
  EXPECT_EQ(means[1].interval.count, 3);
  EXPECT_DOUBLE_EQ(means[1].interval.mean, 2.0);
  EXPECT_NEAR(means[1].interval.half_width, 4.302653 / std::sqrt(3.0), 1e-5);
  EXPECT_TRUE(
      canonical_means(rows, CanonicalMeasure::kAlongOverInto, CanonicalMotion::kPressed, true)
          .empty());
}

}  // namespace
}  // namespace palpate
