#pragma once

// Which scene a command is about: its options, and how it is loaded.

#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/result.h"

namespace palpate {

// Which part of a file is loaded, and how large. As given on the command line.
struct SceneOptions {
  std::string path;
  std::string node;
  std::optional<double> scale;
  std::optional<double> fit_size_m;
  bool fits_workspace = false;  // --fit auto: to the workspace, where it does not fit as it is
  std::string pose;             // "NAME@SECONDS"; empty: at rest
  std::vector<std::string> materials;  // "NAME.key=value" each
  std::string max_memory;              // "500M"; empty: half of what is free
};

void add_scene(CLI::App& app, SceneOptions& scene, bool is_required = true);

// Checks the options and loads the scene. An error names the option.
Result<Scene> load_scene(const SceneOptions& options, double proxy_radius_m);

// The same for a session: refuses what ticks at this rate cannot make felt.
Result<Scene> load_scene(const SceneOptions& options, const RunSettings& run);

}  // namespace palpate
