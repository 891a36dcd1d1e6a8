#include <cstdio>
#include <string>
#include <vector>

#include "engine/accuracy/accuracy_csv.h"
#include "engine/accuracy/accuracy_json.h"
#include "engine/accuracy/accuracy_report.h"
#include "engine/accuracy/advice.h"
#include "engine/accuracy/stiffness_picture.h"
#include "engine/devices/light_device.h"
#include "engine/report/html.h"
#include "engine/report/text_file.h"
#include "tests/engine/accuracy/sample_knobs.h"
#include "tests/engine/report/sample_reports.h"

namespace palpate {
namespace {

bool succeeded(const Result<std::string>& written) {
  if (!written) std::fprintf(stderr, "%s\n", written.error().to_string().c_str());
  return written.ok();
}

}  // namespace

bool test::write_accuracy_sample(const std::string& folder) {
  const std::vector<KnobResult> results = all_samples();
  AccuracyReport report;
  report.title = "What accuracy costs";
  report.introduction = "Made-up results, to view the report.";
  report.facts = {{"machine", "none"},
                  {"compiler", "GNU 12.2.0"},
                  {"flags", "-O3 -DNDEBUG"},
                  {"commit", "unknown"},
                  {"seed", "1"},
                  {"repeats", "21"}};
  AdviceInput input;
  input.results = results;
  input.device = light_device();
  report.advice = *advise(input);
  report.chapters = chapters_of(results);
  report.sections.push_back({"Your scene", "<p>" + html_escaped("a < b") + "</p>"});
  const StiffnessChart chart = *stiffness_chart(light_device(), {}, 1000.0);
  bool good =
      succeeded(write_text_file(folder + "/accuracy.json",
                                accuracy_json({*report.advice, {}, results, nullptr, chart}))) &&
      succeeded(write_text_file(folder + "/stiffness.svg", stiffness_chart_svg(chart))) &&
      succeeded(write_text_file(folder + "/report.html", report_html(report))) &&
      succeeded(write_accuracy_csv(results, folder + "/report.csv"));
  for (std::size_t i = 0; good && i < results.size(); ++i) {
    const auto svg = work_precision_svg(results[i]);
    good = succeeded(svg) &&
           succeeded(write_text_file(folder + "/knob" + std::to_string(i) + ".svg", *svg));
  }
  return good;
}

}  // namespace palpate
