#include "engine/commands.h"

#include <filesystem>
#include <iomanip>
#include <iostream>
#include <locale>
#include <numbers>
#include <optional>
#include <sstream>

#include <nlohmann/json.hpp>

#include "engine/command_output.h"
#include "engine/node_tree.h"
#include "engine/path_picture.h"
#include "engine/prepared_run.h"
#include "engine/replay.h"
#include "engine/report.h"
#include "engine/run_advice.h"
#include "engine/run_judgement.h"
#include "engine/run_summary.h"
#include "engine/scene.h"
#include "engine/text_file.h"
#include "io/trace_csv.h"
#include "io/trajectory.h"

namespace palpate {
namespace {

constexpr int kNotComparable = 3;

std::optional<Error> write_trace(const std::string& path, const std::vector<TickRecord>& records,
                                 const std::vector<std::int64_t>& steps_ns) {
  Result<TraceWriter> writer = TraceWriter::create(path);
  if (!writer) return writer.error();
  for (std::size_t i = 0; i < records.size(); ++i) {
    const TickRecord& r = records[i];
    writer->add({r.tick, r.time_s, r.device_m, r.goal_m, r.proxy_m, r.normal_scene,
                 r.force_device_N, r.contact, r.alpha_rad * 180.0 / std::numbers::pi,
                 r.T_device_scene, friction_name(r.friction), fault_names(r.faults), steps_ns[i]});
  }
  const Result<std::size_t> written = writer->finish();
  if (!written) return written.error();
  return std::nullopt;
}

// What the hand followed: a place a line, scene frame.
std::optional<Error> write_way(const ExplorationRun& run, const std::string& folder) {
  const bool is_walk = run.contour_scene_m.empty();
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << std::setprecision(17) << "x,y,z\n";
  for (const Vec3& p : is_walk ? run.places_scene_m : run.contour_scene_m) {
    text << p.x() << "," << p.y() << "," << p.z() << "\n";
  }
  const std::string path =
      folder + (is_walk ? "/places-" : "/contour-") + (run.a4 ? "on" : "off") + ".csv";
  const auto written = write_text_file(path, text.str());
  if (!written) return written.error();
  return std::nullopt;
}

Error with_path(Error error, const std::string& path) {
  if (error.path.empty()) error.path = path;
  return error;
}

// What runs the same for every run of a command.
std::string run_heading(const RunCommand& command, const PreparedRun& prepared) {
  const ActuationModel& actuation = prepared.setup.actuation;
  std::ostringstream text;
  text << command.scene.path << ": " << prepared.scene.statistics().cleaning.triangles
       << " triangles, " << actuation.sensors() << " sensors, " << actuation.actuators()
       << " actuators, workspace " << command.exploration.workspace_m
       << " m along each sensed axis";
  if (actuation.is_planar()) {
    text << ", plane at A3 = " << prepared.setup.haptics.plane_height_m << " m";
  }
  if (const double scale = prepared.scene.statistics().scale; scale != 1.0) {
    text << ", scale " << scale;
  }
  return text.str() + "\n";
}

nlohmann::ordered_json runs_json(const RunCommand& command, const PreparedRun& prepared,
                                 const std::vector<ExplorationRun>& runs,
                                 const std::optional<Advice>& advice) {
  nlohmann::ordered_json json{{"comparable", are_comparable(runs)}};
  json["reasons"] = nlohmann::ordered_json::array();
  for (const ExplorationRun& r : runs) {
    for (const std::string& reason : reasons(r)) {
      json["reasons"].push_back((r.a4 ? "with A4: " : "without A4: ") + reason);
    }
  }
  json["try"] = advice ? nlohmann::ordered_json(advice->command_line) : nlohmann::ordered_json();
  json["workspace_m"] = command.exploration.workspace_m;
  if (prepared.setup.actuation.is_planar()) {
    json["plane_height_m"] = prepared.setup.haptics.plane_height_m;
  }
  json["scale"] = prepared.scene.statistics().scale;
  json["runs"] = nlohmann::ordered_json::array();
  for (const ExplorationRun& r : runs) json["runs"].push_back(run_json(r, prepared.scene));
  return json;
}

}  // namespace

int info(const InfoCommand& command) {
  const Result<Scene> scene = load_scene(command.scene, 0.0);
  if (!scene) return refuse(scene.error());
  if (command.json) {
    print(command.list ? tree_json(*scene) : scene_json(*scene));
  } else {
    std::cout << (command.list ? command.scene.path + "\n" + tree_text(scene->tree())
                               : scene_text(command.scene.path, *scene));
  }
  return finish_output();
}

int replay(const ReplayCommand& command) {
  const Result<RunSetup> setup = make_setup(command.options);
  if (!setup) return refuse(setup.error());
  const Result<std::vector<Vec3>> path = read_trajectory(command.trajectory);
  if (!path) return refuse(path.error());
  const Result<Scene> scene = load_scene(command.scene, command.options);
  if (!scene) return refuse(scene.error());
  tell_what_was_not_understood(*scene);
  const Result<ReplayResult> result = replay(*scene, *setup, *path, command.repeat);
  if (!result) return refuse(result.error());
  if (!command.trace.empty()) {
    if (const auto error = write_trace(command.trace, result->records, result->steps_ns)) {
      return refuse(*error);
    }
  }
  if (command.json) {
    print(summary_json(result->summary, *scene));
  } else {
    std::cout << command.scene.path << ", " << command.trajectory << "\n"
              << summary_text(result->summary, *scene);
  }
  return finish_output();
}

int run(const RunCommand& command) {
  const Result<PreparedRun> prepared = prepare_run(command);
  if (!prepared) return refuse(with_path(prepared.error(), command.scene.path));
  const Scene& scene = prepared->scene;
  tell_what_was_not_understood(scene);
  if (const auto error = make_out_folder(command.out_dir)) return refuse(*error);
  std::vector<ExplorationRun> runs;
  for (const bool a4 : {false, true}) {
    if (!command.wants(a4)) continue;
    RunSetup setup = prepared->setup;
    setup.haptics.a4.enabled = a4;
    const ProgressBar bar(a4 ? "with A4   " : "without A4");
    Result<ExplorationRun> run =
        explore(scene, setup, command.exploration, [&](double share) { bar.show(share); });
    if (!run) return refuse(with_path(run.error(), command.scene.path));
    const std::string trace = command.out_dir + (a4 ? "/trace-on.csv" : "/trace-off.csv");
    if (const auto error = write_trace(trace, run->records, run->steps_ns)) return refuse(*error);
    if (const auto error = write_way(*run, command.out_dir)) return refuse(*error);
    runs.push_back(std::move(*run));
  }
  const std::string name = std::filesystem::path(command.scene.path).filename().string();
  const auto picture = write_path_picture(runs, name, command.out_dir + "/paths.svg");
  if (!picture) std::cerr << "palpate: " << picture.error().to_string() << "\n";
  if (!runs.front().realtime_note.empty()) {
    std::cerr << "palpate: " << runs.front().realtime_note << "\n";
  }
  const bool is_comparable = are_comparable(runs);
  std::optional<Advice> advice;
  if (!is_comparable) {
    const ProgressBar bar("what to try");
    advice = advise(command, *prepared, runs, [&](double share) { bar.show(share); });
  }
  if (command.json) {
    print(runs_json(command, *prepared, runs, advice));
  } else {
    std::cout << judgement_text(runs, advice) << run_heading(command, *prepared)
              << runs_text(runs, scene) << "traces" << (picture ? " and paths.svg" : "") << " in "
              << command.out_dir << "/\n";
  }
  const int code = finish_output();
  return code == 0 && !is_comparable ? kNotComparable : code;
}

}  // namespace palpate
