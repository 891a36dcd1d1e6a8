#pragma once

// The names of the results that runs write into their folders, and which results a folder has.

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// What is run (dealt_run.h), and what its units are.
enum class RunKind : std::uint8_t { kExperiment, kCanonical, kSweep };
struct RunKindWords {
  std::string_view name;  // in run.json; empty: the entry is absent
  std::string_view noun;  // of a unit
  const char* nouns;      // the entry of their count in run.json
};
inline constexpr std::array<RunKindWords, 3> kRunKinds = {
    {{"", "participant", "participants"},
     {"canonical", "participant", "participants"},
     {"sweep", "point", "points"}}};
constexpr const RunKindWords& words_of(RunKind kind) {
  return kRunKinds[static_cast<std::size_t>(kind)];
}

// The result that states the identity of every run. It is the last one to appear.
inline constexpr const char* kRunFile = "run.json";
inline constexpr const char* kColumnsFile = "columns.csv";

// Of an experiment.
inline constexpr const char* kTrialsFile = "trials.csv";
// Of a canonical run.
inline constexpr const char* kCanonicalFile = "canonical.csv";
inline constexpr const char* kCanonicalPage = "canonical.html";
// Of a sweep. The tables of its page are in CSV files of these names.
inline constexpr const char* kSweepFile = "sweep.csv";
inline constexpr const char* kSweepPage = "report.html";
inline constexpr const char* kSweepJson = "sweep_results.json";
inline constexpr std::array<std::string_view, 4> kSweepTableNames = {"one_at_a_time", "flips",
                                                                     "rankings", "halves"};

// The names of the results of a run of this kind that palpate.analysis makes: the page and its
// tables.
std::vector<std::string> page_names(RunKind kind);

// The names of all results of a run of this kind. kRunFile is the last one.
std::vector<std::string> result_names(RunKind kind);

// The results of such a run that the folder has, without kRunFile; empty if it has none. A folder
// has those of an experiment or of a sweep if its run.json states such a run: the program has not
// written a trials.csv without it.
std::vector<std::string> results_in(const std::string& folder, RunKind kind);

// The results of runs of other kinds that the folder has: a run of this kind replaces them.
std::vector<std::string> results_of_other_kinds_in(const std::string& folder, RunKind kind);

}  // namespace palpate
