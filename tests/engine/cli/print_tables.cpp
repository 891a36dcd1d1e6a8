// Prints the tables of the program from which docs/generate.py writes pages, as JSON: the settings
// of a run, and the members of a tick's record with their columns in a trace.

#include <cmath>
#include <cstdio>
#include <sstream>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/session/run_setting.h"
#include "engine/session/trace_csv.h"
#include "palpate/record.h"

namespace palpate {
namespace {

// "0 to 3", "above 0", "none, actuated, full" or "".
std::string values_of(const RunSetting& setting) {
  std::ostringstream values;
  const bool is_number = std::isfinite(setting.range.least);
  if (is_number && std::isfinite(setting.range.most)) {
    values << setting.range.least << " to " << setting.range.most;
  } else if (is_number) {
    values << (setting.range.is_least_out ? "above " : "at least ") << setting.range.least;
  }
  if (const auto* choice = std::get_if<SettingChoice>(&setting.value)) {
    for (const std::string_view word : choice->words) {
      values << (word == choice->words.front() ? "" : ", ") << word;
    }
  }
  return values.str();
}

nlohmann::json settings() {
  nlohmann::json rows = nlohmann::json::array();
  for (const RunSetting& setting : run_settings()) {
    if (setting.option.empty()) continue;  // only recordings have it
    rows.push_back({{"option", setting.option},
                    {"key", setting.plan.name ? setting.plan.name : ""},
                    {"values", values_of(setting)},
                    {"unit", setting.unit},
                    {"meaning", std::string(setting.meaning) + std::string(setting.note)}});
  }
  return rows;
}

nlohmann::json record() {
  static constexpr const char* kTypes[] = {"uint64", "int64",  "double",
                                           "uint32", "uint16", "int32"};
  nlohmann::json rows = nlohmann::json::array();
  for (const RecordField& field : kRecordFields) {
    rows.push_back({{"name", field.name},
                    {"type", kTypes[static_cast<int>(field.type)]},
                    {"count", field.count},
                    {"unit", field.unit},
                    {"frame", field.frame},
                    {"column", field.column},
                    {"is_of_session", field.is_of_session}});
  }
  return rows;
}

}  // namespace
}  // namespace palpate

int main() {
  const nlohmann::json tables = {{"settings", palpate::settings()},
                                 {"record", palpate::record()},
                                 {"trace_columns", palpate::trace_columns()}};
  std::puts(tables.dump(1).c_str());
}
