#include "io/gltf/scene_choice.h"

#include <charconv>
#include <string_view>

#include <nlohmann/json.hpp>

#include "io/gltf/error.h"
#include "io/gltf/json.h"
#include "io/gltf/tinygltf.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr const char* kVisibility = "KHR_node_visibility";

bool is_number(std::string_view text) {
  return !text.empty() && text.find_first_not_of("0123456789") == text.npos;
}

// no_value: too large for any index.
std::size_t index_in(std::string_view digits) {
  std::size_t index = 0;
  const auto [rest, failed] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
  return failed == std::errc() ? index : std::string_view::npos;
}

// "0 "Scene", 1 without a name and 3 more"
std::string scenes_text(const tinygltf::Model& model) {
  constexpr std::size_t kMostNames = 12;
  std::string text;
  for (std::size_t i = 0; i < model.scenes.size() && i < kMostNames; ++i) {
    const std::string& name = model.scenes[i].name;
    text += (i == 0 ? "" : ", ") + std::to_string(i) +
            (name.empty() ? " without a name" : " " + in_quotes(name));
  }
  if (model.scenes.size() > kMostNames) {
    text += " and " + std::to_string(model.scenes.size() - kMostNames) + " more";
  }
  return text;
}

Error wrong_choice(const tinygltf::Model& model, const std::string& choice,
                   const std::string& problem) {
  const std::string element = "`SceneSettings::listed_scene`";
  if (model.scenes.empty()) {
    return gltf_error(ErrorCode::kInvalidArgument, element,
                      "is " + in_quotes(choice) + ", but the file lists no scene", "leave it out");
  }
  return gltf_error(
      ErrorCode::kInvalidArgument, element,
      "is " + in_quotes(choice) + ", " + problem + "; the scenes are " + scenes_text(model),
      "state the number of a scene, or its name if no other scene has it");
}

// Whether a target of an animation, "/nodes/3/extensions/KHR_node_visibility/visible", is a
// visibility.
bool is_visibility(const Json& channel) {
  const auto target = channel.is_object() ? channel.find("target") : channel.end();
  if (target == channel.end() || !target->is_object()) return false;
  const auto extension = find_extension(*target, "", "KHR_animation_pointer");
  if (!extension || !*extension) return false;
  const auto pointer = (*extension)->find("pointer");
  return pointer != (*extension)->end() && pointer->is_string() &&
         pointer->get_ref<const std::string&>().find(kVisibility) != std::string::npos;
}

bool changes_visibility(const Json& animation) {
  const auto channels = animation.is_object() ? animation.find("channels") : animation.end();
  if (channels == animation.end() || !channels->is_array()) return false;
  for (const Json& channel : *channels) {
    if (is_visibility(channel)) return true;
  }
  return false;
}

}  // namespace

Result<std::optional<std::size_t>> choose_scene(const tinygltf::Model& model,
                                                const std::string& choice) {
  const std::size_t count = model.scenes.size();
  if (choice.empty()) {
    if (count == 0) return std::optional<std::size_t>();
    return std::optional(model.defaultScene < 0 ? 0 : static_cast<std::size_t>(model.defaultScene));
  }
  std::vector<std::size_t> named;
  for (std::size_t i = 0; i < count && !is_number(choice); ++i) {
    if (model.scenes[i].name == choice) named.push_back(i);
  }
  if (named.size() == 1) return std::optional(named.front());
  if (named.size() > 1) {
    return wrong_choice(model, choice,
                        "the name of " + std::to_string(named.size()) + " scenes of the file");
  }
  std::string_view digits = choice;
  if (digits.front() == '#') digits.remove_prefix(1);
  if (!is_number(digits)) return wrong_choice(model, choice, "which no scene of the file is named");
  const std::size_t index = index_in(digits);
  if (index < count) return std::optional(index);
  return wrong_choice(model, choice, "but the file has " + std::to_string(count) + " scenes");
}

Result<bool> is_hidden(const Json& node, std::size_t node_id) {
  if (!node.is_object()) return false;
  const std::string element = gltf_element("nodes", node_id);
  const auto extension = find_extension(node, element, kVisibility);
  if (!extension) {
    Error error = extension.error();
    error.hint = "write {\"visible\": false} to hide the node, or remove the extension";
    return error;
  }
  if (!*extension) return false;
  const auto visible = (*extension)->find("visible");
  if (visible == (*extension)->end()) return false;
  if (visible->is_boolean()) return !visible->get<bool>();
  // Exporters write custom properties of the type integer for flags.
  if (visible->is_number() && (*visible == 0 || *visible == 1)) return *visible == 0;
  return gltf_expected(element + "/extensions/" + kVisibility + "/visible", *visible,
                       "true or false, or 1 or 0");
}

void note_animated_visibility(const Json& root, std::vector<std::string>& notes) {
  const auto animations = root.find("animations");
  if (animations == root.end() || !animations->is_array()) return;
  std::size_t count = 0;
  std::size_t first = 0;
  for (std::size_t i = 0; i < animations->size(); ++i) {
    if (!changes_visibility((*animations)[i])) continue;
    if (count++ == 0) first = i;
  }
  if (count == 0) return;
  const std::string others = count > 1 ? " and " + std::to_string(count - 1) + " more" : "";
  notes.push_back(gltf_element("animations", first) + others +
                  ": the visibility of nodes is animated, which is not read; nodes are visible or "
                  "hidden as the nodes of the file state");
}

}  // namespace palpate
