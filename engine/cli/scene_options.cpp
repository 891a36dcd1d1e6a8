#include "engine/cli/scene_options.h"

#include <cmath>
#include <iostream>
#include <sstream>
#include <utility>

#include "engine/cli/command_help.h"
#include "engine/cli/number_option.h"
#include "engine/cli/setting_texts.h"
#include "engine/scene/memory_budget.h"

namespace palpate {
namespace {

// The argument is a size or "auto".
CLI::Option* add_fit(CLI::App& app, SceneOptions& scene) {
  const auto read = [&scene](const std::string& text) {
    scene.fits_workspace = text == "auto";
    if (scene.fits_workspace) return;
    const auto size_m = parse_real("--fit", text, kAboveZero);
    if (!size_m) throw CLI::ValidationError("--fit", size_m.error().problem + ", or auto");
    scene.fit_size_m = *size_m;
  };
  return app
      .add_option_function<std::string>("--fit", read,
                                        "scale the scene to this largest extent, m; auto (only "
                                        "run): to the workspace, if the scene "
                                        "does not fit")
      ->type_name("NUMBER");
}

}  // namespace

void add_scene(CLI::App& app, SceneOptions& scene, bool is_required) {
  app.add_option("SCENE", scene.path, "glTF 2.0 file, .gltf or .glb")->required(is_required);
  app.add_option("--node", scene.node,
                 "load only this node and its descendants, by name or \"#number\" (info --list)")
      ->group(kSceneGroup);
  app.add_option("--scene", scene.listed_scene,
                 "load this scene of the file, by its number or name; digits are always a number "
                 "(info lists the scenes) [the file's default scene]")
      ->type_name("N|NAME")
      ->group(kSceneGroup);
  app.add_flag("--feel-hidden", scene.feels_hidden,
               "load nodes that the file hides (KHR_node_visibility), too")
      ->group(kSceneGroup);
  add_real(app, "--scale", scene.scale, kAboveZero, "scale the scene by this factor")
      ->group(kSceneGroup);
  add_fit(app, scene)->group(kSceneGroup);
  app.add_option("--pose", scene.pose,
                 "NAME@SECONDS: pose of one animation at one time; \"#number@SECONDS\" uses the "
                 "number that "
                 "info prints [the file's rest pose]")
      ->group(kSceneGroup);
  add_real(app, "--close-gaps", scene.close_gaps_m, kAboveZero,
           "join open edges of a mesh, and surfaces of nodes, that are at most this far apart, m; "
           "info prints how far")
      ->group(kSceneGroup);
  app.add_option("--material", scene.materials,
                 "NAME.key=value: replace a value of a material in the file; may be repeated")
      ->expected(1)
      ->take_all()
      ->group(kSceneGroup);
  app.add_option("--max-memory", scene.max_memory,
                 "memory limit of loading, bytes, such as 500M or 2GiB [half of the free memory]")
      ->group(kSceneGroup);
}

Result<SceneSettings> scene_settings_of(const SceneOptions& options, double proxy_radius_m) {
  SceneSettings settings;
  settings.proxy_radius_m = proxy_radius_m;
  settings.node = options.node;
  settings.listed_scene = options.listed_scene;
  settings.feels_hidden = options.feels_hidden;
  settings.pose = options.pose;
  settings.close_gaps_m = options.close_gaps_m.value_or(0.0);
  if (options.scale && options.fit_size_m) {
    return invalid_argument("--fit", "is used together with --scale; use one of them");
  }
  if (options.fits_workspace) {
    return invalid_argument("--fit", "is auto, but only run has a workspace",
                            "state the largest extent in metres, such as --fit 0.2");
  }
  if (options.scale) settings.scale = *options.scale;
  if (options.fit_size_m) settings.fit_size_m = *options.fit_size_m;
  if (!options.max_memory.empty()) {
    const auto bytes = parse_bytes(options.max_memory);
    if (!bytes) return bytes.error();
    settings.max_memory_bytes = *bytes;
  }
  auto overrides = parse_overrides(options.materials);
  if (!overrides) return overrides.error();
  settings.overrides = std::move(*overrides);
  return settings;
}

Result<Scene> load_scene(const SceneOptions& options, double proxy_radius_m, bool measures_gaps) {
  auto settings = scene_settings_of(options, proxy_radius_m);
  if (!settings) return settings.error();
  settings->measures_gaps = measures_gaps;
  return load_scene(options, *settings);
}

Result<Scene> load_scene(const SceneOptions& options, const SceneSettings& settings) {
  auto scene = Scene::load(options.path, settings);
  if (scene && settings.close_gaps_m > 0.0 && !options.is_quiet) {
    const SceneStatistics& s = scene->statistics();
    const JoinStatistics& joins = s.gap_joins;
    std::cerr << "palpate: --close-gaps joined " << joins.joined_edges << " pairs of edges and "
              << joins.joined_vertices << " vertices; " << joins.ambiguous_edges
              << " edges stay open because they meet several others";
    if (s.changed_nodes > 0) {
      std::cerr << "; moved " << s.changed_nodes << " nodes onto nodes that they meet";
    }
    std::cerr << "\n";
  }
  return scene;
}

Result<Scene> load_scene(const SceneOptions& options, const SceneSettings& settings,
                         double rate_Hz) {
  auto scene = load_scene(options, settings);
  if (!scene) return scene;
  if (auto error = check_tick_rate(scene->effects(), rate_Hz)) {
    error->path = options.path;
    return *error;
  }
  return scene;
}

Result<Scene> load_scene(const SceneOptions& options, const RunSettings& run) {
  const auto settings = scene_settings_of(options, run.haptics.god_object.radius_m);
  if (!settings) return settings.error();
  return load_scene(options, *settings, run.rate_Hz);
}

}  // namespace palpate
