#pragma once

// Which nodes of a file are read: those of one of its scenes, and of these the visible ones.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace tinygltf {
class Model;
}

namespace palpate {

struct GltfSceneChoice {
  // The number of a scene, "1" or "#1", or its name. Digits alone are always a number. Empty: the
  // default scene, else the first scene, else all root nodes.
  std::string scene = {};
  bool feels_hidden = false;  // reads hidden nodes like visible ones
};

// The index of the chosen scene; no value: all root nodes. An error (kInvalidArgument, with a list
// of the scenes) if no scene, or more than one, is meant. Thread-safe, like the other functions.
Result<std::optional<std::size_t>> choose_scene(const tinygltf::Model& model,
                                                const std::string& choice);

// Whether KHR_node_visibility hides a node, and with it all its descendants. An error if the
// extension has another form.
Result<bool> is_hidden(const nlohmann::json& node, std::size_t node_id);

// Adds a note if animations change the visibility of nodes, which is not read.
void note_animated_visibility(const nlohmann::json& root, std::vector<std::string>& notes);

}  // namespace palpate
