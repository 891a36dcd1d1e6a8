#include "engine/cli/run_advice.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <sstream>
#include <utility>

#include "engine/cli/command_line.h"
#include "engine/cli/option_names.h"
#include "engine/rig/placed_bounds.h"
#include "engine/scene/memory_budget.h"
#include "engine/simulation/path_plan.h"
#include "engine/simulation/run_judgement.h"

namespace palpate {
namespace {

using Changes = std::vector<OptionSetting>;

// Trials end after this many loaded triangles: some seconds of work.
constexpr std::size_t kMostTriangles = 20'000'000;
constexpr std::size_t kMostNodes = 3;

// Covers the rounding of two numbers to three digits, half of the last digit each.
constexpr double kMoreThanRounded = 1.02;

// Values of --place that turn the scene's y axis, or its x axis, along A3.
constexpr const char* kOtherPlanes[] = {"0 0 0 0.7071068 0.7071068 0 0",
                                        "0 0 0 0.7071068 0 0.7071068 0"};

std::string text_of(double x, int digits = 3) {
  std::ostringstream text;
  text.precision(digits);
  text << x;
  return text.str();
}

// Enough digits that the last digit is less than a hundredth of the step.
std::string text_in_steps(double x, double step) {
  const double digits = 3 + std::ceil(std::log10(std::abs(x) / step));
  return text_of(x, static_cast<int>(std::clamp(digits, 3.0, 17.0)));
}

RunRequest changed(RunRequest command, const Changes& changes) {
  RunOptions& options = command.options;
  RunSettings& settings = options.settings;
  for (const auto& [option, value] : changes) {
    const std::string text = value.value_or("");
    const double number = std::strtod(text.c_str(), nullptr);
    if (option == "--workspace") set_workspace_extent(settings.device, number);
    if (option == "--seconds") command.exploration.seconds = number;
    if (option == "--plane-height") {
      settings.plane_height_m = value ? std::optional(number) : std::nullopt;
    }
    if (option == "--place") options.place = text;
    if (option == "--radius") settings.haptics.god_object.radius_m = number;
    if (option == "--actuated-axes") options.actuated_axes = text;
    if (option == "--actuators") settings.actuators = std::nullopt;  // a change only removes it
    if (option == "--sensors") settings.sensors = static_cast<int>(number);
    if (option == "--node") command.scene.node = text;
    if (option == "--fit") {
      command.scene.fit_size_m = number;
      command.scene.scale.reset();
      command.scene.fits_workspace = false;
    }
  }
  return command;
}

// Reduces the allowed memory of a trial by the memory of the present scene and runs; false if none
// remains.
bool limit_memory(const PreparedRun& prepared, const std::vector<ExplorationRun>& runs,
                  RunRequest& command) {
  if (command.scene.max_memory.empty()) return true;  // each load then uses half of the free memory
  std::uint64_t used = prepared.scene.statistics().memory.total();
  for (const ExplorationRun& run : runs) used += run.record_bytes();
  const std::uint64_t allowed =
      *parse_bytes(command.scene.max_memory);  // prepare_run() parsed it without an error
  if (allowed <= used) return false;
  command.scene.max_memory = std::to_string(allowed - used);
  command.exploration.max_memory_bytes = allowed - used;
  return true;
}

// The requested runs in simulated time; no value if one fails or is interrupted.
std::optional<std::vector<ExplorationRun>> try_run(RunRequest command, const StopFlag* stop) {
  command.scene.is_quiet = command.options.is_quiet = true;
  const Result<PreparedRun> prepared = prepare_run(command);
  if (!prepared) return std::nullopt;
  command.exploration.virtual_time = true;
  command.exploration.taken_memory_bytes = prepared->scene.statistics().memory.total();
  std::vector<ExplorationRun> runs;
  for (const bool a4 : {false, true}) {
    if (!command.wants(a4)) continue;
    RunSetup setup = prepared->setup;
    setup.haptics.a4.enabled = a4;
    auto run = explore(
        prepared->scene, setup, command.exploration, [](double) {}, stop);
    if (!run || run->interrupted) return std::nullopt;
    runs.push_back(std::move(*run));
  }
  return runs;
}

double least_path_share(const std::vector<ExplorationRun>& runs) {
  double least = 1.0;
  for (const ExplorationRun& run : runs) {
    least = std::min(least, run.summary.contact_ticks > 0 ? run.way_share : 0.0);
  }
  return least;
}

class Candidates {
 public:
  Candidates(const RunRequest& command, const PreparedRun& prepared,
             const std::vector<ExplorationRun>& runs)
      : command_(command),
        prepared_(prepared),
        runs_(runs),
        bounds_(bounds_in_device(prepared.scene, prepared.setup.haptics.initial_pose)) {}

  std::vector<Changes> list() {
    add_time();
    add_size();
    add_radii();
    if (prepared_.setup.actuation.is_planar()) {
      add_planes();
      add_heights();
    }
    add_nodes();
    add_sensors();
    add_workspaces();
    add_unpinned();
    return std::move(changes_);
  }

 private:
  void add_time() {
    const double seconds = command_.exploration.seconds;
    if (std::none_of(runs_.begin(), runs_.end(), was_still_getting_on)) return;
    for (const double times : {2.0, 4.0}) {
      changes_.push_back({{"--seconds", text_of(times * seconds)}});
    }
  }

  // The largest size that the workspace allows.
  void add_size() {
    constexpr double kWorthIt = 1.3;
    constexpr double kPartToFill = 0.95;
    const Vec3 extent_m = bounds_.high - bounds_.low;
    const double widest_m = extent_m.head(command_.options.settings.sensors).maxCoeff();
    const double clearance_m = 4 * PathPlanSettings{}.press_depth_m;
    const double factor = kPartToFill *
                          (workspace_extent_m(command_.options.settings.device) - clearance_m) /
                          widest_m;
    const double largest_m = prepared_.scene.statistics().extent_m.maxCoeff();
    if (!(factor > kWorthIt) || !std::isfinite(factor * largest_m)) return;
    changes_.push_back({{"--fit", text_of(factor * largest_m)}});
  }

  // A smaller sphere reaches more of the contour, a point reaches most.
  void add_radii() {
    const double radius_m = command_.options.settings.haptics.god_object.radius_m;
    if (!(radius_m > 0.0)) return;
    for (const double part : {0.5, 0.1}) {
      changes_.push_back({{"--radius", text_of(part * radius_m)}});
    }
    changes_.push_back({{"--radius", std::nullopt}});
  }

  void add_planes() {
    if (is_place_pinned()) return;
    for (const char* pose : kOtherPlanes) changes_.push_back({{"--place", pose}});
  }

  void add_sensors() {
    if (command_.options.actuated_axes.empty()) changes_.push_back(other_sensors());
  }

  // For parts that are small compared with the press depth at every size that fits: sizes of four
  // or sixteen press depths.
  void add_workspaces() {
    const double depth_m = PathPlanSettings{}.press_depth_m;
    const Vec3 extent_m = bounds_.high - bounds_.low;
    const double widest_m = extent_m.head(command_.options.settings.sensors).maxCoeff();
    double path_m = std::numeric_limits<double>::infinity();
    for (const ExplorationRun& run : runs_) {
      if (slips_off(run)) path_m = std::min(path_m, way_extent_m(run));
    }
    if (!(path_m > 0.0) || !std::isfinite(path_m)) return;
    for (const double depths : {4.0, 16.0}) {
      const double factor = depths * depth_m / path_m;
      const double size_m = factor * prepared_.scene.statistics().extent_m.maxCoeff();
      const double workspace_m = kMoreThanRounded * (factor * widest_m + 4 * depth_m);
      changes_.push_back({{"--workspace", text_of(workspace_m)}, {"--fit", text_of(size_m)}});
    }
  }

  // With 2 sensors --actuators 3 is removed: a planar device has no third motor.
  Changes other_sensors() const {
    if (command_.options.settings.sensors == 2) return {{"--sensors", "3"}};
    if (command_.options.settings.actuators.value_or(0) <= 2) return {{"--sensors", "2"}};
    return {{"--sensors", "2"}, {"--actuators", std::nullopt}};
  }

  bool is_place_pinned() const {
    return !command_.options.place.empty() || command_.options.settings.plane_height_m;
  }

  // Removes options that fix the scene's place, one by one and then all; then tries the planes and
  // sensors that those options had excluded above.
  void add_unpinned() {
    const RunOptions& options = command_.options;
    Changes all;
    if (!options.place.empty()) all.push_back({"--place", std::nullopt});
    if (options.settings.plane_height_m) all.push_back({"--plane-height", std::nullopt});
    if (!options.actuated_axes.empty()) all.push_back({"--actuated-axes", std::nullopt});
    for (const OptionSetting& pin : all) changes_.push_back({pin});
    if (all.size() > 1) changes_.push_back(all);
    if (prepared_.setup.actuation.is_planar() && is_place_pinned()) {
      for (const char* pose : kOtherPlanes) {
        changes_.push_back({{"--place", pose}, {"--plane-height", std::nullopt}});
      }
    }
    if (options.actuated_axes.empty()) return;
    Changes sensors = other_sensors();
    sensors.push_back({"--actuated-axes", std::nullopt});
    changes_.push_back(std::move(sensors));
  }

  void add_heights() {
    for (const double part : {0.35, 0.65, 0.2, 0.8}) {
      const double height_m = bounds_.low.z() + part * (bounds_.high.z() - bounds_.low.z());
      changes_.push_back(
          {{"--plane-height", text_in_steps(height_m, bounds_.high.z() - bounds_.low.z())}});
    }
  }

  // Each of the largest nodes alone, fitted to half of the workspace.
  void add_nodes() {
    const auto& objects = prepared_.scene.objects();
    std::vector<std::pair<double, std::uint32_t>> by_extent;
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const Box box = prepared_.scene.world().bodies[i].box_solver();
      by_extent.push_back({-(box.high - box.low).norm(), objects[i].tree_node});
    }
    std::sort(by_extent.begin(), by_extent.end());
    std::set<std::uint32_t> added;
    for (const auto& [unused, node] : by_extent) {
      if (added.size() == kMostNodes) return;
      if (!added.insert(node).second) continue;
      if (by_extent.size() == 1) return;
      const std::uint32_t number = prepared_.scene.tree()[node].file_index;
      changes_.push_back(
          {{"--node", "#" + std::to_string(number)},
           {"--fit", text_of(0.5 * workspace_extent_m(command_.options.settings.device))}});
    }
  }

  const RunRequest& command_;
  const PreparedRun& prepared_;
  const std::vector<ExplorationRun>& runs_;
  Box bounds_;
  std::vector<Changes> changes_;
};

// The recording exists now, so that the same command with it would be refused.
std::vector<std::string> without_record(std::vector<std::string> arguments) {
  constexpr std::string_view kRecord = "--record";
  for (auto word = arguments.begin(); word != arguments.end();) {
    if (*word == kRecord && word + 1 != arguments.end()) {
      word = arguments.erase(word, word + 2);
    } else if (word->starts_with("--record=")) {
      word = arguments.erase(word);
    } else {
      ++word;
    }
  }
  return arguments;
}

}  // namespace

std::optional<RunAdvice> advise_run(const RunRequest& command, const PreparedRun& prepared,
                                    const std::vector<ExplorationRun>& runs,
                                    const Progress& progress, const StopFlag* stop) {
  constexpr double kFarther = 0.05;
  const std::vector<Changes> candidates = Candidates(command, prepared, runs).list();
  const std::size_t triangles = prepared.scene.statistics().instanced_triangles;
  std::optional<RunAdvice> best;
  std::size_t loaded = 0;
  for (std::size_t i = 0; i < candidates.size() && loaded <= kMostTriangles; ++i) {
    if (stop && stop->requested()) break;
    progress(static_cast<double>(i) / static_cast<double>(candidates.size()));
    loaded += triangles;
    RunRequest candidate = changed(command, candidates[i]);
    if (!limit_memory(prepared, runs, candidate)) break;
    const auto tried = try_run(std::move(candidate), stop);
    if (!tried) continue;
    const double least = least_path_share(*tried);
    const bool ends_comparable = are_comparable(*tried);
    const double to_beat = best ? best->least_way_share : least_path_share(runs) + kFarther;
    if (!ends_comparable && least <= to_beat) continue;
    best = RunAdvice{shell_line(with_options(without_record(command.arguments), candidates[i])),
                     ends_comparable, least};
    if (ends_comparable) break;
  }
  return best;
}

std::string judgement_text(const std::vector<ExplorationRun>& runs,
                           const std::optional<RunAdvice>& advice, bool is_search_cut) {
  std::string found;
  for (const ExplorationRun& run : runs) {
    if (run.interrupted) continue;
    for (const std::string& reason : reasons(run)) {
      found += std::string("  ") + (run.a4 ? "with A4: " : "without A4: ") +
               with_option_names(reason) + "\n";
    }
  }
  if (found.empty()) return {};
  std::string text = "not comparable\n" + found;
  if (!advice) {
    return text + (is_search_cut
                       ? "  the search for better options was interrupted\n"
                       : "  no other options that were tried in simulated time did better\n");
  }
  text += "  try: " + advice->command_line + "\n";
  const auto percent = std::lround(100 * advice->least_way_share);
  return text + "  (in simulated time the proxy then came near " + std::to_string(percent) +
         (advice->ends_comparable ? " % of the path)\n"
                                  : " % of the path: more, but not enough)\n");
}

}  // namespace palpate
