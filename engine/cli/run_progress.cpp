#include "engine/cli/run_progress.h"

namespace palpate {

std::string duration_text(double seconds) {
  const auto s = static_cast<long long>(seconds + 0.5);
  if (s < 60) return std::to_string(s) + " s";
  if (s < 3600) return std::to_string(s / 60) + " min " + std::to_string(s % 60) + " s";
  return std::to_string(s / 3600) + " h " + std::to_string(s % 3600 / 60) + " min";
}

std::function<void(const RunProgress&)> shown_in(ProgressBar& bar, const std::string& label) {
  return [&bar, label](const RunProgress& progress) {
    bar.show(progress.time_left_s ? label + ", " + duration_text(*progress.time_left_s) + " left"
                                  : label,
             progress.share);
  };
}

}  // namespace palpate
