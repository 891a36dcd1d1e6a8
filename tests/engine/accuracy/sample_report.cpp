#include <cstdio>
#include <string>
#include <vector>

#include "engine/accuracy/accuracy_json.h"
#include "engine/accuracy/advice.h"
#include "engine/accuracy/stiffness_picture.h"
#include "engine/devices/light_device.h"
#include "engine/report/text_file.h"
#include "tests/engine/accuracy/sample_knobs.h"
#include "tests/engine/report/sample_reports.h"

namespace palpate {

bool test::write_accuracy_sample(const std::string& folder) {
  std::vector<KnobResult> results = all_samples();
  results.back().knob.name = "hostile";  // names are names of files
  AdviceInput input;
  input.results = results;
  input.device = light_device();
  const Advice advice = *advise(input);
  const StiffnessChart chart = *stiffness_chart(light_device(), {}, 1000.0);
  const std::string json = accuracy_json({advice, {}, results, nullptr, chart});
  for (const auto& written :
       {write_text_file(folder + "/accuracy.json", json),
        write_text_file(folder + "/stiffness.svg", stiffness_chart_svg(chart))}) {
    if (written) continue;
    std::fprintf(stderr, "%s\n", written.error().to_string().c_str());
    return false;
  }
  return true;
}

}  // namespace palpate
