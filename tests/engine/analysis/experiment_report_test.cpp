// The report of an experiment: its numbers against the analysis and against counts of the rows,
// what it states, and what it does not write.

#include "engine/analysis/experiment_report.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/analysis/report_verdicts.h"
#include "engine/analysis/statistics_text.h"
#include "engine/report/text_file.h"
#include "engine/trials/csv_reader.h"
#include "engine/trials/trials_file.h"
#include "tests/engine/analysis/sample_trials.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/random.h"

namespace palpate::test {
namespace {

namespace fs = std::filesystem;

const TrialSource kSource = {"trials.csv", 120.0};
const std::vector<std::string> kAllFollowings = {"delayed", "predict", "replan", "frozen"};

std::vector<TrialRow> simulated_rows() {
  return sample_trials({.followings = kAllFollowings, .has_timeouts = true});
}

// With the measures that an analysis needs, and no other.
std::vector<TrialRow> minimal_rows() {
  auto rows = sample_trials({});
  for (TrialRow& row : rows) {
    for (std::size_t m = 0; m < kMeasureCount; ++m) {
      if (m != kTotalTime && m != kLosses && m != kPenetration) row.measures[m].reset();
    }
  }
  return rows;
}

// The files of a report, by name, and its text for the terminal.
struct Written {
  ExperimentAnalysis analysis;
  std::map<std::string, std::string> files;
  std::string text;
};

Written written(std::vector<TrialRow> rows, const TrialSource& source = kSource) {
  const TemporaryFolder folder;
  auto analysed = report_trials(std::move(rows), source, folder.path("out"));
  if (!analysed) {
    ADD_FAILURE() << analysed.error().to_string();
    return {};
  }
  EXPECT_TRUE(analysed->warnings.empty());
  EXPECT_FALSE(analysed->files.move_into_place());
  Written result{std::move(analysed->analysis), {}, std::move(analysed->text)};
  for (const auto& entry : fs::directory_iterator(folder.path("out"))) {
    result.files[entry.path().filename().string()] = content_of(entry.path().string());
  }
  return result;
}

// The lines of a CSV file, as values by column.
using CsvRow = std::map<std::string, std::string>;
std::vector<CsvRow> csv_rows(const std::string& text) {
  CsvReader reader(text);
  std::vector<std::string> header, fields;
  EXPECT_TRUE(*reader.next(header));
  std::vector<CsvRow> rows;
  while (*reader.next(fields)) {
    EXPECT_EQ(fields.size(), header.size());
    CsvRow row;
    for (std::size_t i = 0; i < fields.size(); ++i) row[header[i]] = fields[i];
    rows.push_back(std::move(row));
  }
  return rows;
}

double number(const std::string& text) {
  double value = std::nan("");
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// The only row with these values.
CsvRow row_with(const std::vector<CsvRow>& rows, const CsvRow& values) {
  std::vector<CsvRow> found;
  for (const CsvRow& row : rows) {
    if (std::all_of(values.begin(), values.end(),
                    [&](const auto& v) { return row.at(v.first) == v.second; })) {
      found.push_back(row);
    }
  }
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? CsvRow{} : found[0];
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t i = text.find(part); i != std::string::npos; i = text.find(part, i + 1)) ++count;
  return count;
}

TEST(ExperimentReport, HasAllFiles) {
  std::set<std::string> names;
  for (const auto& [name, text] : written(sample_trials({})).files) names.insert(name);
  EXPECT_EQ(names, (std::set<std::string>{"report.html", "analysis.json", "effects.csv",
                                          "comparisons.csv", "means.csv", "missing_trials.csv",
                                          "findings.csv", "differences.csv"}));
}

// The columns that name a row differ between any two rows of a table.
TEST(ExperimentReport, NamesEachRowOfATableOnce) {
  const std::map<std::string, std::vector<std::string>> names = {
      {"effects.csv", {"following", "analysis", "outcome", "effect"}},
      {"comparisons.csv", {"following", "analysis", "outcome", "family", "pair"}},
      {"means.csv", {"following", "of", "outcome", "haptic", "rotation", "object"}},
      {"missing_trials.csv", {"following", "haptic", "rotation", "object"}},
      {"findings.csv", {"following", "finding"}}};
  for (const bool is_simulated : {false, true}) {
    SampleTrials settings;
    if (is_simulated) settings.followings = {"delayed", "frozen"};
    const Written report = written(sample_trials(settings));
    for (const auto& [file, columns] : names) {
      std::set<std::vector<std::string>> seen;
      for (const CsvRow& row : csv_rows(report.files.at(file))) {
        std::vector<std::string> name;
        for (const std::string& column : columns) name.push_back(row.at(column));
        EXPECT_TRUE(seen.insert(name).second) << file << ": " << testing::PrintToString(name);
      }
    }
  }
}

// A following whose effects cannot be tested agrees or disagrees with nobody.
TEST(ExperimentReport, DoesNotCallAMissingTestAFlip) {
  auto rows = sample_trials({.followings = {"delayed"}});
  auto incomplete = sample_trials({.followings = {"frozen"}});
  for (TrialRow& row : incomplete) {
    if (row.haptic == "UaH" && row.object == "O2") row.status = TrialStatus::kTimeout;
  }
  rows.insert(rows.end(), incomplete.begin(), incomplete.end());
  const auto analysis = analyse_trials(rows, 120.0);
  ASSERT_TRUE(analysis.ok()) << analysis.error().to_string();
  for (std::size_t i = 0; i < paper_findings().size(); ++i) {
    EXPECT_FALSE(verdicts_differ(*analysis, i)) << paper_findings()[i].name;
  }
}

// 15 effects of four factors: in the MANOVA, in three ANOVAs and in the repeated measures of six
// outcomes; 7 effects of UaH alone.
TEST(ExperimentReport, HasEveryF) {
  const Written report = written(sample_trials({}));
  const auto rows = csv_rows(report.files.at("effects.csv"));
  EXPECT_EQ(rows.size(), 15u * (1 + 3 + 6) + 7);
  const OperatorAnalysis& analysis = report.analysis.operators[0];
  for (const PrimaryAnalysis& primary : analysis.primary) {
    for (const PrimaryEffect& effect : primary.effects) {
      const CsvRow row =
          row_with(rows, {{"analysis", "repeated measures"},
                          {"outcome", std::string(outcome_text(primary.outcome).name)},
                          {"effect", effect_name(effect.term)}});
      EXPECT_EQ(number(row.at("f")), effect.test->f);  // all digits are there
      EXPECT_EQ(number(row.at("p")), effect.test->p);
      EXPECT_EQ(number(row.at("gg_p")), effect.test->p_gg);
      EXPECT_EQ(number(row.at("gg_epsilon")), effect.test->epsilon);
      EXPECT_EQ(number(row.at("generalized_eta2")), effect.test->generalized_eta2);
      EXPECT_EQ(row.at("participants"), "10");
    }
  }
  const CsvRow anova = row_with(
      rows,
      {{"analysis", "anova"}, {"outcome", "mean penetration"}, {"effect", "Rotation x Haptic"}});
  const auto& terms = analysis.paper->terms;
  const auto place = std::find(terms.begin(), terms.end(), FactorSet{0, 1}) - terms.begin();
  EXPECT_EQ(number(anova.at("f")), analysis.paper->anovas[2].effects[place].f);
  EXPECT_EQ(anova.at("df2"), "648");
  EXPECT_EQ(anova.at("trials"), "720");
  EXPECT_EQ(number(anova.at("paper_f")), 22.859);
}

// The cells of the rows of the first table after a heading, without tags.
std::vector<std::vector<std::string>> page_rows(const std::string& page,
                                                const std::string& heading) {
  const auto plain = [](const std::string& html) {
    std::string text;
    bool is_tag = false;
    for (const char c : html) {
      if (c == '<') is_tag = true;
      if (!is_tag) text += c;
      if (c == '>') is_tag = false;
    }
    return text;
  };
  std::vector<std::vector<std::string>> rows;
  const std::size_t start = page.find("<tbody>", page.find(heading));
  const std::string body = page.substr(start, page.find("</tbody>", start) - start);
  for (std::size_t i = body.find("<tr>"); i != std::string::npos; i = body.find("<tr>", i + 1)) {
    const std::string row = body.substr(i, body.find("</tr>", i) - i);
    rows.emplace_back();
    for (std::size_t c = row.find("<td"); c != std::string::npos; c = row.find("<td", c + 1)) {
      rows.back().push_back(plain(row.substr(c, row.find("</td>", c) - c)));
    }
  }
  return rows;
}

TEST(ExperimentReport, PageHasEachFBesideThePapers) {
  const Written report = written(sample_trials({}));
  const OperatorAnalysis& analysis = report.analysis.operators[0];
  const auto& terms = analysis.paper->terms;
  for (std::size_t outcome = 0; outcome < 3; ++outcome) {
    const PrimaryAnalysis& primary = *analysis.primary_of(kPaperOutcomes[outcome]);
    const std::string heading[] = {"Total time (s)", "Losses of contact", "Mean penetration (dm)"};
    const auto rows =
        page_rows(report.files.at("report.html"), "<h4>" + heading[outcome] + "</h4>");
    ASSERT_EQ(rows.size(), 15u);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const PrimaryEffect& effect = primary.effects[i];
      const auto place = std::find(terms.begin(), terms.end(), effect.term) - terms.begin();
      const FixedEffectTest& fixed = analysis.paper->anovas[outcome].effects[place];
      ASSERT_EQ(rows[i].size(), 14u);
      EXPECT_EQ(rows[i][0], effect_name(effect.term));
      EXPECT_EQ(rows[i][2], number_or_dash(fixed.f));
      EXPECT_EQ(rows[i][5], with_decimals(fixed.partial_eta2, 3));
      EXPECT_EQ(rows[i][6], "720");
      EXPECT_EQ(rows[i][7], number_or_dash(effect.test->f));
      EXPECT_EQ(rows[i][8], df_text(effect.test->df1) + ", " + df_text(effect.test->df2));
      EXPECT_EQ(rows[i][10], with_decimals(effect.test->epsilon, 3));
      EXPECT_EQ(rows[i][12], with_decimals(effect.test->generalized_eta2, 3));
      EXPECT_EQ(rows[i][13], "10");
    }
    const std::string printed[][3] = {{"12.141", "29.674", "0.433 (n.s.)"},
                                      {"19.139", "22.389", "2.608 (p &lt; .07)"},
                                      {"836.377", "0.845 (n.s.)", "22.859"}};
    EXPECT_EQ(rows[0][1], printed[outcome][0]);
    EXPECT_EQ(rows[1][1], printed[outcome][1]);
    EXPECT_EQ(rows[3][0], "Rotation x Haptic");
    EXPECT_EQ(rows[3][1], printed[outcome][2]);
  }
}

TEST(ExperimentReport, PageHasMeansBesideThePapers) {
  const Written report = written(sample_trials({}));
  const auto means = csv_rows(report.files.at("means.csv"));
  const auto rows =
      page_rows(report.files.at("report.html"), "<h3>Means and standard deviations of trials</h3>");
  ASSERT_EQ(rows.size(), 1u + 3 + 2 + 4 + 6);
  const auto mean_at = [&](const char* outcome, const char* haptic, int decimals) {
    const CsvRow row = row_with(means, {{"of", "trials"},
                                        {"outcome", outcome},
                                        {"haptic", haptic},
                                        {"rotation", "all"},
                                        {"object", "all"}});
    return with_decimals(number(row.at("mean")), decimals) + " (" +
           with_decimals(number(row.at("sd")), decimals) + ")";
  };
  const char* const levels[] = {"NoH", "UaH", "H"};
  const char* const printed[][3] = {{"29 (15)", "24 (11)", "0.101 (0.031)"},
                                    {"27.5 (15)", "22 (11)", "0.068 (0.023)"},
                                    {"25 (13)", "21 (10)", "0.031 (0.008)"}};
  for (std::size_t h = 0; h < 3; ++h) {
    const auto& row = rows[1 + h];
    EXPECT_EQ(row[0], levels[h]);
    EXPECT_EQ(row[1], "240");
    EXPECT_EQ(row[2], mean_at("total time", levels[h], 2));
    EXPECT_EQ(row[4], mean_at("losses of contact", levels[h], 2));
    EXPECT_EQ(row[6], mean_at("mean penetration", levels[h], 4));
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(row[3 + 2 * i], printed[h][i]);
  }
  EXPECT_EQ(rows[4][3], "25.14 (12.041)");  // NoR
  EXPECT_EQ(rows[5][3], "29.15 (15.972)");  // R
}

TEST(ExperimentReport, PageHasTheManovaBesideThePapers) {
  const Written report = written(sample_trials({}));
  const PaperAnalysis& paper = *report.analysis.operators[0].paper;
  const auto rows = page_rows(report.files.at("report.html"), "<h3>MANOVA");
  ASSERT_EQ(rows.size(), 15u);
  std::map<std::string, std::string> lambdas;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][0], effect_name(paper.terms[i]));
    EXPECT_EQ(rows[i][4], with_decimals(paper.manova[i].lambda, 3));
    EXPECT_EQ(rows[i][5], number_or_dash(paper.manova[i].f));
    if (!rows[i][1].empty()) lambdas[rows[i][0]] = rows[i][1];
  }
  EXPECT_EQ(lambdas, (std::map<std::string, std::string>{{"Haptic", "0.236"},
                                                         {"Rotation", "0.925"},
                                                         {"Object", "0.110"},
                                                         {"Trial", "0.925"},
                                                         {"Rotation x Haptic", "0.911"},
                                                         {"Object x Haptic", "0.868"},
                                                         {"Object x Rotation", "0.934"}}));
}

// The paper's contact angles are those of UaH: no other angle stands beside them.
TEST(ExperimentReport, HasThePapersAnglesBesideUaHAlone) {
  const auto rows = csv_rows(written(sample_trials({})).files.at("means.csv"));
  std::set<std::string> beside;
  for (const CsvRow& row : rows) {
    if (row.at("outcome") != "mean contact angle" || row.at("paper_mean").empty()) continue;
    beside.insert(row.at("of") + " " + row.at("haptic") + " " + row.at("rotation") + " " +
                  row.at("paper_mean"));
  }
  EXPECT_EQ(beside.size(), 6u) << "of trials, of participants, and of participants in UaH alone";
  EXPECT_TRUE(beside.contains("trials UaH R 32.100000000000001"));
  EXPECT_TRUE(beside.contains("participants, UaH UaH R 32.100000000000001"));
  EXPECT_TRUE(beside.contains("participants UaH NoR 49.399999999999999"));
}

TEST(ExperimentReport, HasTheMeansOfTheRows) {
  const auto rows = simulated_rows();
  const Written report = written(rows);
  const auto means = csv_rows(report.files.at("means.csv"));
  for (const std::string& following : kAllFollowings) {
    double sum = 0.0, squares = 0.0;
    int n = 0;
    const auto counts = [&](const TrialRow& row) {
      return row.following == following && row.block > 0 && row.haptic == "UaH" &&
             row.status == TrialStatus::kDone;
    };
    for (const TrialRow& row : rows) {
      if (!counts(row)) continue;
      sum += *row.measures[kTotalTime];
      ++n;
    }
    for (const TrialRow& row : rows) {
      if (counts(row)) squares += std::pow(*row.measures[kTotalTime] - sum / n, 2);
    }
    const CsvRow found = row_with(means, {{"following", following},
                                          {"of", "trials"},
                                          {"outcome", "total time"},
                                          {"haptic", "UaH"},
                                          {"rotation", "all"},
                                          {"object", "all"}});
    EXPECT_EQ(found.at("n"), std::to_string(n));
    EXPECT_NEAR(number(found.at("mean")), sum / n, 1e-12 * sum / n);
    EXPECT_NEAR(number(found.at("sd")), std::sqrt(squares / (n - 1)), 1e-12 * sum / n);
    EXPECT_EQ(found.at("paper_mean"), "27.5");
  }
}

TEST(ExperimentReport, CountsTimeoutsByCondition) {
  const auto rows = simulated_rows();
  const Written report = written(rows);
  const auto missing = csv_rows(report.files.at("missing_trials.csv"));
  EXPECT_EQ(missing.size(), 4u * 25);
  std::map<std::string, int> timeouts;
  for (const TrialRow& row : rows) {
    if (row.block == 0 || row.status != TrialStatus::kTimeout) continue;
    ++timeouts[row.following + row.haptic + row.rotation + row.object];
    ++timeouts[row.following + "allallall"];
  }
  for (const CsvRow& row : missing) {
    const int expected =
        timeouts[row.at("following") + row.at("haptic") + row.at("rotation") + row.at("object")];
    EXPECT_EQ(row.at("timeouts"), std::to_string(expected));
    EXPECT_LE(number(row.at("timeout_share_low")), number(row.at("timeout_share")));
    EXPECT_GE(number(row.at("timeout_share_high")), number(row.at("timeout_share")));
  }
  const int all = timeouts["frozenallallall"];
  EXPECT_GT(all, 10);
  EXPECT_TRUE(has(report.text, "missing: " + std::to_string(all) + " (" + std::to_string(all) +
                                   " timeouts, 0 faults, 0 absent)"))
      << report.text;
  EXPECT_TRUE(
      has(report.files.at("report.html"), std::to_string(720 - all) +
                                              " of 720 trials were completed by 10 participants; "
                                              "timeouts: " +
                                              std::to_string(all)));
  // The time with timeouts as the limit is that of `frozen` alone.
  for (const CsvRow& row : csv_rows(report.files.at("effects.csv"))) {
    if (row.at("outcome") == "total time, timeouts as the limit") {
      EXPECT_EQ(row.at("following"), "frozen");
    }
  }
}

TEST(ExperimentReport, JsonHasTheNumbersOfTheTables) {
  const Written report = written(simulated_rows());
  const auto json = nlohmann::json::parse(report.files.at("analysis.json"));
  EXPECT_EQ(json["operators"].size(), 4u);
  EXPECT_EQ(json["operators"][3]["following"], "frozen");
  EXPECT_EQ(json["limit_s"], 120.0);
  for (const std::string_view name : kAnalysisTableNames) {
    const auto rows = csv_rows(report.files.at(std::string(name) + ".csv"));
    const auto& objects = json[std::string(name)];
    ASSERT_EQ(objects.size(), rows.size()) << name;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      ASSERT_EQ(objects[i].size(), rows[i].size());
      for (const auto& [column, text] : rows[i]) {
        const auto& value = objects[i][column];
        if (value.is_null()) {
          EXPECT_EQ(text, "");
        } else if (value.is_string()) {
          EXPECT_EQ(text, value.get<std::string>());
        } else {
          EXPECT_EQ(number(text), value.get<double>()) << name << " " << column;
        }
      }
    }
  }
}

TEST(ExperimentReport, StatesEachVerdict) {
  const Written report = written(simulated_rows());
  const std::string& page = report.files.at("report.html");
  std::array<int, kVerdictNames.size()> all{};
  for (const OperatorAnalysis& each : report.analysis.operators) {
    for (const FindingResult& result : each.findings) ++all[static_cast<int>(result.verdict)];
  }
  EXPECT_EQ(count_of(page, ">agrees</span>"), all[0]);
  EXPECT_EQ(count_of(page, ">disagrees</span>"), all[1]);
  EXPECT_EQ(count_of(page, ">not testable</span>"), all[2]);
  const auto leading = verdict_counts(report.analysis.operators[0]);
  EXPECT_EQ(leading[0] + leading[1] + leading[2], static_cast<int>(paper_findings().size()));
  EXPECT_TRUE(has(page, "Of the paper\u2019s 17 findings, " + std::to_string(leading[0]) +
                            " agree, " + std::to_string(leading[1]) + " disagree"));
  const auto rows = csv_rows(report.files.at("findings.csv"));
  EXPECT_EQ(rows.size(), 4u * 17);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const FindingResult& result = report.analysis.operators[i / 17].findings[i % 17];
    EXPECT_EQ(rows[i].at("verdict"), kVerdictNames[static_cast<int>(result.verdict)]);
    EXPECT_EQ(rows[i].at("because"), result.because);
  }
}

// `predict` has the opposite effects.
TEST(ExperimentReport, MarksVerdictsThatFlip) {
  auto rows = sample_trials({.followings = {"delayed"}});
  const auto opposite = sample_trials({.followings = {"predict"}, .effects = -1.0});
  rows.insert(rows.end(), opposite.begin(), opposite.end());
  const Written report = written(rows);
  const auto& a = report.analysis.operators[0].findings;
  const auto& b = report.analysis.operators[1].findings;
  int flips = 0;
  for (std::size_t i = 0; i < a.size(); ++i) flips += a[i].verdict != b[i].verdict ? 1 : 0;
  EXPECT_GT(flips, 3);
  EXPECT_EQ(count_of(report.files.at("report.html"), ">flips between followings<"), flips);
  EXPECT_EQ(static_cast<int>(differing_findings(report.analysis).size()), flips);
  EXPECT_TRUE(has(report.text, std::to_string(flips) + " verdicts flip between followings\n"));
  for (const CsvRow& row : csv_rows(report.files.at("findings.csv"))) {
    flips -= row.at("differs_between_followings") == "1" && row.at("following") == "predict";
  }
  EXPECT_EQ(flips, 0);
}

TEST(ExperimentReport, NamesSimulatedOperatorsAndNotPeople) {
  const std::string simulated = written(simulated_rows()).files.at("report.html");
  EXPECT_TRUE(
      has(simulated, "<title>The paper\u2019s experiment with simulated operators</title>"));
  for (const std::string& following : kAllFollowings) {
    EXPECT_EQ(count_of(simulated, ": simulated operators, " + following + "</text>"), 3);
  }
  EXPECT_TRUE(has(simulated, "not of people"));
  EXPECT_TRUE(has(simulated, "The rule of alignment may be one reason."));
  const Written people = written(sample_trials({}));
  EXPECT_FALSE(has(people.files.at("report.html"), "imulated"));
  EXPECT_TRUE(has(people.files.at("report.html"), "27 %"));
  EXPECT_TRUE(has(people.text, "720 trials of 10 people; missing: none\n")) << people.text;
  EXPECT_FALSE(has(people.text, "imulated"));
  auto both = sample_trials({.followings = {"delayed"}});
  const auto rows = sample_trials({});
  both.insert(both.end(), rows.begin(), rows.end());
  const Written mixed = written(both);
  EXPECT_TRUE(has(mixed.text, "1440 trials of 10 people and simulated operators"));
  EXPECT_FALSE(has(mixed.files.at("report.html"), "between followings"));
}

TEST(ExperimentReport, TextForTheTerminalIsShortAndStatesTheVerdicts) {
  const Written report = written(simulated_rows());
  EXPECT_EQ(report.text.find("2880 trials of 10 simulated operators (delayed, predict, replan, "
                             "frozen); missing: "),
            0u)
      << report.text;
  const auto counts = verdict_counts(report.analysis.operators[0]);
  EXPECT_TRUE(has(report.text, "the paper's 17 findings, delayed: " + std::to_string(counts[0]) +
                                   (counts[0] == 1 ? " agrees" : " agree")));
  EXPECT_LE(count_of(report.text, "\n"), 4 + 10 + 3);
  EXPECT_TRUE(has(report.text, "\nreport.html, analysis.json and 6 tables are in "));
  for (std::size_t i = 0; i < 10; ++i) {
    std::string line(
        kVerdictNames[static_cast<int>(report.analysis.operators[0].findings[i].verdict)]);
    line.resize(14, ' ');
    EXPECT_TRUE(has(report.text, "\n  " + line + paper_findings()[i].name + ": "));
  }
  // The effects of the MANOVA have a line for each verdict, in the paper's order.
  std::map<std::string, std::string> effects;
  for (std::size_t i = 10; i < paper_findings().size(); ++i) {
    std::string& list = effects[std::string(
        kVerdictNames[static_cast<int>(report.analysis.operators[0].findings[i].verdict)])];
    list += (list.empty() ? "" : ", ") +
            paper_findings()[i].name.substr(paper_findings()[i].name.find(", ") + 2);
  }
  for (const auto& [verdict, list] : effects) {
    const std::string label = verdict + std::string(14 - verdict.size(), ' ');
    EXPECT_TRUE(has(report.text, "\n  " + label + "MANOVA: effects of " + list + "\n"))
        << report.text;
    EXPECT_TRUE(has(report.files.at("report.html"),
                    "<li><strong>MANOVA</strong>: effects of " + list + "</li>"));
  }
}

TEST(ExperimentReport, LeavesOutWhatTheFileDoesNotHave) {
  const Written report = written(minimal_rows());
  const std::string& page = report.files.at("report.html");
  EXPECT_TRUE(has(page, "No Figure 7: the file does not have the contact angle of UaH."));
  EXPECT_FALSE(has(page, "class=\"figure7\""));
  EXPECT_EQ(count_of(page, "class=\"figure6\""), 1);
  EXPECT_TRUE(has(page, "The file does not have the column mean_contact_angle_deg"));
  for (const char* name : {"effects.csv", "means.csv", "comparisons.csv"}) {
    for (const CsvRow& row : csv_rows(report.files.at(name))) {
      EXPECT_NE(row.at("outcome"), "mean contact angle");
      EXPECT_NE(row.at("outcome"), "losses of contact of 100 ms or more");
    }
  }
  EXPECT_FALSE(has(page, "<h4>Losses of contact of 100 ms or more"));
  EXPECT_EQ(csv_rows(report.files.at("findings.csv"))[9].at("verdict"), "not testable");
}

TEST(ExperimentReport, TakesFactorsWithOneLevel) {
  for (const std::string level : {"NoR", "R"}) {
    const Written report = written(sample_trials({.blocks = 1, .rotation = {level}}));
    const std::string& page = report.files.at("report.html");
    EXPECT_TRUE(has(page, "Rotation is left out, because the file has one level of it: " + level));
    EXPECT_TRUE(has(page, level == "R" ? ">R: the scene turns<" : ">NoR: the scene stands still<"));
    EXPECT_FALSE(has(page, "\u00b1 nan"));
    EXPECT_FALSE(has(page, "\u00b1 -"));
  }
  const Written uah = written(sample_trials({.haptic = {"UaH"}}));
  EXPECT_TRUE(has(uah.files.at("report.html"), "class=\"figure7\""));
}

TEST(ExperimentReport, ExplainsAFollowingThatThePapersAnalysisCannotTake) {
  auto rows = sample_trials({.followings = {"delayed", "frozen"}});
  for (TrialRow& row : rows) {
    if (row.following == "frozen" && row.haptic == "H" && row.rotation == "R") {
      row.status = TrialStatus::kTimeout;
    }
  }
  const TemporaryFolder folder;
  auto report = report_trials(rows, kSource, folder.path("out"));
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->warnings.size(), 2u);  // Figure 6 has no mean of all conditions
  ASSERT_FALSE(report->files.move_into_place());
  const std::string page = content_of(folder.path("out/report.html"));
  EXPECT_TRUE(has(page,
                  "The paper\u2019s analysis is not possible. No trial of H, R, O1 was "
                  "completed: its effects cannot be separated."));
  EXPECT_TRUE(has(page, "no participant has completed trials in all its conditions"));
}

TEST(ExperimentReport, IsTheSameForRowsInAnyOrder) {
  auto rows = simulated_rows();
  const auto first = written(rows).files;
  Random random(18301);
  for (std::size_t i = rows.size(); i > 1; --i) std::swap(rows[i - 1], rows[random.index(i)]);
  EXPECT_EQ(written(rows).files, first);
}

TEST(ExperimentReport, EscapesNamesOfTheFile) {
  auto rows = sample_trials({});
  for (TrialRow& row : rows) {
    if (row.object == "O2") row.object = "<script>alert(1)</script>, \"cup\"";
  }
  const Written report = written(rows, {"<b>.csv", 120.0});
  EXPECT_FALSE(has(report.files.at("report.html"), "<script"));
  EXPECT_FALSE(has(report.files.at("report.html"), "<b>"));
  EXPECT_TRUE(has(report.files.at("report.html"), "&lt;script&gt;alert(1)"));
  bool is_found = false;
  for (const CsvRow& row : csv_rows(report.files.at("missing_trials.csv"))) {
    is_found = is_found || row.at("object") == "<script>alert(1)</script>, \"cup\"";
  }
  EXPECT_TRUE(is_found);
  EXPECT_EQ(nlohmann::json::parse(report.files.at("analysis.json"))["file"], "<b>.csv");
}

// A page that works offline: no script, and no address of another document.
TEST(ExperimentReport, NeedsNoOtherFile) {
  const std::string page = written(simulated_rows()).files.at("report.html");
  for (const char* part : {"<script", "<link rel=\"stylesheet", " src=", "@import", "url(http",
                           "href=\"http", "href='http"}) {
    EXPECT_FALSE(has(page, part)) << part;
  }
}

// The files of a folder, by name.
std::map<std::string, std::string> content_of_folder(const std::string& folder) {
  std::map<std::string, std::string> files;
  if (!fs::exists(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    files[entry.path().filename().string()] = content_of(entry.path().string());
  }
  return files;
}

struct RefusedRows {
  const char* name;
  std::function<void(std::vector<TrialRow>&)> change;
  const char* message;
};

TEST(ExperimentReport, RefusedRowsChangeNoFile) {
  const RefusedRows refused[] = {
      {"one participant",
       [](auto& rows) {
         std::erase_if(rows, [](const TrialRow& row) { return row.participant != "4"; });
       },
       "trials.csv: participant: has 1 level beside practice"},
      {"no losses",
       [](auto& rows) {
         for (TrialRow& row : rows) row.measures[kLosses].reset();
       },
       "trials.csv: losses_of_contact: is in no completed trial"},
      {"trial beyond the limit",
       [](auto& rows) {
         rows[40].status = TrialStatus::kTimeout;
         rows[41].measures[kTotalTime] = 130.0;
       },
       "trials.csv: participant 1, block 1, H, NoR, O2, total_time_s: is 130 in a completed trial; "
       "expected at most the time limit, 120 s, because the file has timeouts (give the time limit "
       "of the trials with --limit)"}};
  const TemporaryFolder folder;
  {
    auto report = report_trials(sample_trials({}), kSource, folder.path("out"));
    ASSERT_TRUE(report.ok());
    ASSERT_FALSE(report->files.move_into_place());
  }
  const auto before = content_of_folder(folder.path("out"));
  EXPECT_EQ(before.size(), 8u);
  for (const RefusedRows& each : refused) {
    auto rows = sample_trials({});
    each.change(rows);
    for (const char* out : {"out", "new"}) {
      const auto report = report_trials(rows, kSource, folder.path(out));
      ASSERT_FALSE(report.ok()) << each.name;
      EXPECT_EQ(report.error().to_string().find(each.message), 0u) << report.error().to_string();
    }
    EXPECT_EQ(content_of_folder(folder.path("out")), before) << each.name;
    EXPECT_FALSE(fs::exists(folder.path("new"))) << each.name;
  }
}

// Without a timeout the limit is not used, and people may take their time.
TEST(ExperimentReport, TakesTrialsBeyondTheLimitIfThereIsNoTimeout) {
  auto rows = sample_trials({});
  rows[41].measures[kTotalTime] = 130.0;
  EXPECT_EQ(written(rows).files.size(), 8u);
}

// The program

std::string csv_of_rows(const std::vector<TrialRow>& rows) {
  CsvLines lines(trials_columns());
  for (const TrialRow& row : rows) add_row(lines, row);
  return lines.text();
}

TEST(ExperimentAnalyse, WritesTheReportOfTheRows) {
  const TemporaryFolder folder;
  const auto rows = sample_trials({.participants = 3, .blocks = 2});
  ASSERT_TRUE(write_text_file(folder.path("trials.csv"), csv_of_rows(rows)));
  const Outcome done = run_program(folder, {"experiment", "analyse", "trials.csv"});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  const Written expected = written(rows);
  EXPECT_EQ(content_of_folder(folder.path("analysis")), expected.files);
  EXPECT_EQ(done.out.substr(0, done.out.rfind(" in ")),
            expected.text.substr(0, expected.text.rfind(" in ")));
  EXPECT_TRUE(has(done.out, " in analysis/\n"));
}

TEST(ExperimentAnalyse, RefusesInOneLineAndWritesNothing) {
  const TemporaryFolder folder;
  auto rows = sample_trials({.participants = 2, .blocks = 1});
  const std::string good = csv_of_rows(rows);
  rows[30].status = TrialStatus::kTimeout;
  ASSERT_TRUE(write_text_file(folder.path("good.csv"), good));
  ASSERT_TRUE(write_text_file(folder.path("timeout.csv"), csv_of_rows(rows)));
  ASSERT_TRUE(
      write_text_file(folder.path("doubled.csv"), good + good.substr(good.rfind("\n,") + 1)));
  ASSERT_TRUE(write_text_file(folder.path("empty.csv"), ""));
  ASSERT_TRUE(write_text_file(folder.path("taken"), "a file"));
  const std::pair<std::vector<std::string>, std::string> refused[] = {
      {{"absent.csv"}, "palpate: absent.csv: "},
      {{"empty.csv"}, "palpate: empty.csv: is empty"},
      {{"doubled.csv"}, "palpate: doubled.csv: line 98: has the trial of line 97 again"},
      {{"."},
       "palpate: .: is a folder; expected a file (name the file of trials in it, such as "
       "./trials.csv)"},
      {{"timeout.csv", "--limit", "20"}, "palpate: timeout.csv: participant 1, block 1, "},
      {{"good.csv", "--limit", "0"}, "palpate: --limit: is \"0\""},
      {{"good.csv", "--out", "taken"}, "palpate: taken: "}};
  const auto before = content_of_folder(folder.path());
  for (const auto& [arguments, message] : refused) {
    std::vector<std::string> all = {"experiment", "analyse"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    const Outcome outcome = run_program(folder, all);
    EXPECT_EQ(outcome.exit_code, 2) << arguments[0];
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.err.find(message), 0u) << outcome.err;
    EXPECT_EQ(count_of(outcome.err, "\n"), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder.path("analysis"))) << arguments[0];
    EXPECT_EQ(content_of(folder.path("taken")), "a file");
  }
}

}  // namespace
}  // namespace palpate::test
