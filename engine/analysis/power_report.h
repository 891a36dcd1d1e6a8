#pragma once

// The report of a PowerStudy: one page for readers, and tables for programs.

#include <string>
#include <vector>

#include "engine/analysis/power_study.h"
#include "engine/report/output_files.h"
#include "geometry/base/result.h"

namespace palpate {

// An HTML5 document (UTF-8) that needs no other file, no network and no script. Appends to
// `warnings` if the figures could not be drawn.
std::string power_report_html(const PowerStudy& study, std::vector<std::string>& warnings);

// The names of the files that write_power_report() writes.
std::vector<std::string> power_report_names();

// Writes report.html, power.json, needed_people.csv and power.csv. files: created with the names of
// power_report_names(). Returns the warnings.
Result<std::vector<std::string>> write_power_report(const PowerStudy& study,
                                                    const OutputFiles& files);

}  // namespace palpate
