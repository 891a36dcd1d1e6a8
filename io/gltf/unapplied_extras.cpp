#include "io/gltf/unapplied_extras.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

#include "io/ascii.h"
#include "io/gltf/error.h"
#include "io/gltf/extras_places.h"

namespace palpate {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kGroup = "palpate";
constexpr std::string_view kContour = "palpate_contour";

// The path of a value; it becomes text only in a line.
struct Path {
  const Path* parent = nullptr;  // outlives this
  std::string_view name = {};    // null data: an index
  std::size_t index = 0;

  Path operator/(std::string_view member) const { return {this, member, 0}; }
  Path operator/(std::size_t i) const { return {this, {}, i}; }
  std::string text() const {
    if (parent == nullptr) return {};
    return parent->text() + "/" +
           (name.data() != nullptr ? shortened(std::string(name)) : std::to_string(index));
  }
};

constexpr std::pair<std::string_view, ExtrasElementKind> kElementSections[] = {
    {"materials", ExtrasElementKind::kMaterial},
    {"scenes", ExtrasElementKind::kScene},
    {"nodes", ExtrasElementKind::kNode},
    {"meshes", ExtrasElementKind::kMesh}};

bool is_letter_or_digit(char c) {
  return is_lower(lower(c)) || is_digit(c);
}

// What follows a word in lower case at the beginning of a name: "Palpate_stiffness" gives
// "stiffness". No value if the name does not begin with the word, in any capital letters and with
// any signs.
std::optional<std::string_view> after_word(std::string_view name, std::string_view word) {
  std::size_t matched = 0;
  std::size_t i = 0;
  for (; i < name.size() && matched < word.size(); ++i) {
    if (static_cast<char>(name[i] | 0x20) == word[matched]) {
      ++matched;
    } else if (is_letter_or_digit(name[i])) {
      return std::nullopt;
    }
  }
  if (matched < word.size()) return std::nullopt;
  while (i < name.size() && !is_letter_or_digit(name[i]) && (name[i] & 0x80) == 0) ++i;
  return name.substr(i);
}

std::optional<std::string_view> after_group_name(std::string_view name) {
  return after_word(name, kGroup);
}

// Whether a name that follows the word palpate means a contour.
bool is_contour_name(std::string_view rest, const Json& value) {
  constexpr std::string_view kName = "contour";
  constexpr std::size_t kMostWrongLetters = 2;
  if (rest.size() > 2 * kName.size()) return false;
  const std::string plain = plain_name(rest);
  if (plain == kName) return true;
  return value.is_structured() &&
         letter_distance(plain, kName, kMostWrongLetters) <= kMostWrongLetters;
}

// Words that other programs use, too, for what Palpate does not mean.
bool is_ordinary(std::string_view key) {
  return key == "solid" || key == "size" || key == "radius" || key == kMediumKey ||
         key == "gravity";
}

// Whether a name says that its values are felt, or that an author invented them.
bool names_haptic_group(std::string_view plain) {
  constexpr std::string_view kWords[] = {"haptic", "tactile", "touch", "custom"};
  return std::any_of(std::begin(kWords), std::end(kWords),
                     [&](std::string_view word) { return plain.find(word) != plain.npos; });
}

// Whether a name is one that simulations of motion give to values with the same words.
bool names_simulation(std::string_view plain) {
  constexpr std::string_view kWords[] = {"phys",   "rigid", "body",   "spring", "collid", "collis",
                                         "cloth",  "joint", "cycle",  "solver", "jolt",   "havok",
                                         "bullet", "ammo",  "rapier", "mujoco"};
  return std::any_of(std::begin(kWords), std::end(kWords),
                     [&](std::string_view word) { return plain.find(word) != plain.npos; });
}

// A long path without its middle.
std::string middle_cut(const std::string& path) {
  constexpr std::size_t kMostBytes = 300;
  if (path.size() <= kMostBytes) return path;
  return path.substr(0, kMostBytes / 2) + "..." + path.substr(path.size() - kMostBytes / 2);
}

class Search {
 public:
  Search(const GltfAsset& asset, const AppliedElements& applied, const KeyNames& names)
      : asset_(asset),
        applied_(applied),
        names_(names),
        places_(asset, applied.scene, names, allowance_) {}

  std::vector<std::string> run() {
    const Path root;
    for (const auto& [name, value] : asset_.json.items()) {
      const auto section = std::find_if(std::begin(kElementSections), std::end(kElementSections),
                                        [&key = name](const auto& s) { return s.first == key; });
      const Path path = root / name;
      if (section == std::end(kElementSections) || !value.is_array()) {
        if (!read_beside_extras(name, value, asset_.json, path, {})) {
          read_member(name, value, path, {}, true);
        }
        continue;
      }
      for (std::size_t i = 0; i < value.size(); ++i) {
        const Path element = path / i;
        walk(value[i], element, {section->second, i}, true);
      }
    }
    if (count_ > lines_.size()) {
      const bool are_all = allowance_ > 0;
      lines_.push_back(std::string("and ") + (are_all ? "" : "at least ") +
                       std::to_string(count_ - lines_.size()) +
                       " more keys or groups in extras are not applied");
    }
    return std::move(lines_);
  }

 private:
  // is_element: the value is the element itself and not a part of it.
  void walk(const Json& value, const Path& path, const ExtrasElement& element, bool is_element) {
    if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        if (value[i].is_structured()) walk(value[i], path / i, element, false);
      }
      return;
    }
    if (!value.is_object()) return;
    for (const auto& [name, member] : value.items()) {
      const Path at = path / name;
      if (is_element && element.kind == ExtrasElementKind::kMesh && name == "primitives" &&
          member.is_array()) {
        for (std::size_t i = 0; i < member.size(); ++i) {
          const Path primitive = at / i;
          walk(member[i], primitive, {ExtrasElementKind::kMesh, element.index, i}, false);
        }
        continue;
      }
      if (!is_element || !read_beside_extras(name, member, value, at, element)) {
        read_member(name, member, at, element, is_element);
      }
    }
  }

  // A key of Palpate directly in an element of the file. Misspelt ones are not searched.
  bool read_beside_extras(const std::string& name, const Json& value, const Json& object,
                          const Path& path, const ExtrasElement& element) {
    KeyNames::Allowance none = 0;
    const auto match = names_.find(name, owner_of(element.kind), none);
    if (!match || match->likeness == KeyLikeness::kNear || !is_meant(*match, value, object)) {
      return false;
    }
    add(path, [&] {
      return "it lies outside extras; " +
             places_.belongs(*match, element, object.contains(kMediumKey));
    });
    return true;
  }

  void read_member(const std::string& name, const Json& value, const Path& path,
                   const ExtrasElement& element, bool is_element) {
    if (name == "extras") return read_extras(value, path, element, is_element);
    const auto rest = after_group_name(name);
    if (rest && (rest->empty() || is_contour_name(*rest, value))) {
      return add(path, [&] {
        return "it lies outside extras; " + places_.belongs(value, element, rest->empty());
      });
    }
    if (value.is_structured()) walk(value, path, element, false);
  }

  void read_extras(const Json& extras, const Path& path, const ExtrasElement& element,
                   bool is_own) {
    if (extras.is_string()) return read_text(extras, path, element);
    if (extras.is_array()) return search_nested(extras, path, element);
    if (!extras.is_object()) return;
    for (const auto& [name, value] : extras.items()) {
      const Path at = path / name;
      if (name == kGroup) {
        read_group(value, at, element, is_own);
      } else if (name == kContour) {
        read_contour(at, element, is_own);
      } else if (const auto rest = after_group_name(name)) {
        read_joined(name, *rest, value, at, element);
      } else if (!read_flat(name, value, extras, at, element) && value.is_structured()) {
        if (!read_misspelt_group(name, value, at, element) &&
            !read_group_of_keys(name, value, at, element)) {
          search_nested(value, at, element);
        }
      }
    }
  }

  // Extras that are a text, which names the group or is an object with a key of Palpate.
  void read_text(const Json& extras, const Path& path, const ExtrasElement& element) {
    const std::string& text = extras.get_ref<const std::string&>();
    const std::string start = plain_name(std::string_view(text).substr(0, 256));
    if (start.find(kGroup) == std::string::npos && !has_keys(object_in(text), element)) return;
    add(path, [&] {
      return std::string(
          "it is a text; expected an object such as {\"palpate\": {\"stiffness\": "
          "400}}");
    });
  }

  // The group palpate of an element.
  void read_group(const Json& group, const Path& path, const ExtrasElement& element, bool is_own) {
    const bool has_values = is_own && owner_of(element.kind) != 0;
    if (!has_values || (element.kind == ExtrasElementKind::kNode && !group.contains(kMediumKey))) {
      return add(path, [&] { return places_.belongs(group, element, true); });
    }
    if (is_applied(element)) return;
    add(path, [&] { return why_not_applied(element); });
  }

  // The object that a text contains; another value without one. Python writes single quotation
  // marks.
  Json object_in(const std::string& text) {
    constexpr std::size_t kMostBytes = 4096;
    constexpr std::size_t kBytesPerName = 16;  // as much work as a compared name
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (text.size() > kMostBytes || begin == text.npos || text[begin] != '{') return nullptr;
    const std::size_t work = 1 + text.size() / kBytesPerName;
    if (work > allowance_) return nullptr;
    allowance_ -= work;
    std::string json = text;
    if (text.find('"') == text.npos) std::replace(json.begin(), json.end(), '\'', '"');
    return Json::parse(json, nullptr, false);  // discarded, which is no object, if it is no JSON
  }

  // Whether an object has a key of Palpate, spelled right, that is no ordinary word.
  bool has_keys(const Json& object, const ExtrasElement& element) const {
    if (!object.is_object()) return false;
    std::size_t looked_at = 0;
    for (const auto& [key, value] : object.items()) {
      if (++looked_at > kMostKeysOfGroup) return false;
      if (is_key(key, value, element)) return true;
    }
    return false;
  }

  bool is_key(const std::string& name, const Json& value, const ExtrasElement& element) const {
    KeyNames::Allowance none = 0;
    const auto match = names_.find(name, owner_of(element.kind), none);
    return match && match->likeness != KeyLikeness::kNear && !is_ordinary(match->key->name) &&
           !value.is_object();
  }

  void read_contour(const Path& path, const ExtrasElement& element, bool is_own) {
    if (is_own && element.kind == ExtrasElementKind::kNode) {
      if (!is_applied(element)) add(path, [&] { return why_not_applied(element); });
      return;
    }
    add(path, [&] { return std::string("it belongs in the extras of a node"); });
  }

  bool is_applied(const ExtrasElement& element) const {
    switch (element.kind) {
      case ExtrasElementKind::kMaterial:
        return element.index < applied_.materials.size() && applied_.materials[element.index];
      case ExtrasElementKind::kNode:
        return element.index < applied_.nodes.size() && applied_.nodes[element.index];
      case ExtrasElementKind::kScene:
        return applied_.scene == element.index;
      default:
        return false;
    }
  }

  std::string why_not_applied(const ExtrasElement& element) const {
    switch (element.kind) {
      case ExtrasElementKind::kMaterial:
        return "no triangle that is loaded has this material";
      case ExtrasElementKind::kNode:
        if (element.index < applied_.hidden_nodes.size() && applied_.hidden_nodes[element.index]) {
          return "the node, or an ancestor, is hidden (KHR_node_visibility); "
                 "`SceneSettings::feels_hidden` loads hidden nodes, too";
        }
        return "the node is not part of the loaded scene";
      default:
        return "another scene of the file is loaded; load this one with "
               "`SceneSettings::listed_scene` " +
               std::to_string(element.index);
    }
  }

  // A name that begins with the word palpate and is not the group's name.
  void read_joined(const std::string& name, std::string_view rest, const Json& value,
                   const Path& path, const ExtrasElement& element) {
    if (rest.empty()) {
      return add(path, [&] {
        return "the name of the group is palpate, not " + in_quotes(name) + "; " +
               places_.belongs(value, element, true);
      });
    }
    if (is_contour_name(rest, value)) {
      return add(path, [&] {
        return std::string("the name is palpate_contour, and it belongs in the extras of a node");
      });
    }
    const auto match = names_.find(rest, owner_of(element.kind), allowance_);
    if (!match && has_keys(value, element)) {
      return add(path, [&] {
        return "the name of the group is palpate, not " + in_quotes(name) + "; " +
               places_.belongs(value, element, true);
      });
    }
    add(path, [&] {
      if (match) return places_.belongs(*match, element, false);
      return "no key is named " + in_quotes(std::string(rest)) +
             "; keys belong in a group palpate of " + owners_text(kOfMaterial | kOfScene);
    });
  }

  // A key of Palpate beside the group.
  bool read_flat(const std::string& name, const Json& value, const Json& extras, const Path& path,
                 const ExtrasElement& element) {
    const auto match = flat_match(name, element);
    if (!match || !is_meant(*match, value, extras)) return false;
    add(path, [&] { return places_.belongs(*match, element, extras.contains(kMediumKey)); });
    return true;
  }

  // The key that a name means, or the rest of a name that begins with the word haptic.
  std::optional<KeyMatch> flat_match(const std::string& name, const ExtrasElement& element) {
    const unsigned owners = owner_of(element.kind);
    for (const std::string_view word : {"haptic", "haptics"}) {
      const auto rest = after_word(name, word);
      if (!rest || rest->empty()) continue;
      auto match = names_.find(*rest, owners, allowance_);
      if (match) return match;
    }
    return names_.find(name, owners, allowance_);
  }

  static bool is_medium(const Json& value) {
    if (!value.is_string()) return false;
    const std::string shape = plain_name(value.get_ref<const std::string&>());
    return shape == "box" || shape == "sphere";
  }

  // Other programs use the same words. A key that is an ordinary word counts only with a value that
  // Palpate gives a meaning.
  static bool is_meant(const KeyMatch& match, const Json& value, const Json& extras) {
    const std::string& key = match.key->name;
    const std::string text =
        value.is_string() ? plain_name(value.get_ref<const std::string&>()) : "";
    if (key == "size" || key == "radius") {
      const auto medium = extras.find(kMediumKey);
      return medium != extras.end() && is_medium(*medium);
    }
    if (key == kMediumKey) return is_medium(value);
    if (key == "solid") {
      const bool is_bit = value.is_number() && (value == 0 || value == 1);
      return value.is_boolean() || is_bit || text == "true" || text == "false";
    }
    return match.likeness != KeyLikeness::kNear || !value.is_object();
  }

  // A group that holds keys of Palpate and has nearly its name.
  bool read_misspelt_group(const std::string& name, const Json& value, const Path& path,
                           const ExtrasElement& element) {
    constexpr std::size_t kMostWrongLetters = 2;
    constexpr std::size_t kMostKeys = 16;
    const std::size_t length = name.size();
    if (!value.is_object() || length + kMostWrongLetters < kGroup.size() || length > 16 ||
        allowance_ == 0) {
      return false;
    }
    --allowance_;
    if (letter_distance(plain_name(name), kGroup, kMostWrongLetters) > kMostWrongLetters)
      return false;
    std::size_t looked_at = 0;
    for (const auto& [key, inner] : value.items()) {
      if (++looked_at > kMostKeys) break;
      const auto match = names_.find(key, owner_of(element.kind), allowance_);
      if (!match || match->likeness == KeyLikeness::kNear) continue;
      add(path, [&] {
        return "the name of the group is palpate, not " + in_quotes(name) + "; " +
               places_.belongs(value, element, true);
      });
      return true;
    }
    return false;
  }

  // A group of another name with nothing but keys of Palpate: two or more, or one if the group's
  // name says that an author made it. A group named haptic may have other keys, too.
  bool read_group_of_keys(const std::string& name, const Json& value, const Path& path,
                          const ExtrasElement& element) {
    if (!value.is_object() || value.empty() || value.size() > kMostKeysOfGroup) return false;
    constexpr std::size_t kLongestName = 64;
    const std::string plain = plain_name(std::string_view(name).substr(0, kLongestName));
    if (names_simulation(plain)) return false;
    const bool may_have_others = plain.find("haptic") != plain.npos;
    std::size_t keys = 0;
    for (const auto& [key, inner] : value.items()) {
      if (is_key(key, inner, element)) {
        ++keys;
      } else if (!is_ordinary(key) && !may_have_others) {
        return false;
      }
    }
    if (keys < (names_haptic_group(plain) ? 1u : 2u)) return false;
    add(path, [&] {
      return "the name of the group is palpate, not " + in_quotes(name) + "; " +
             places_.belongs(value, element, true);
    });
    return true;
  }

  // Groups of other programs may hold anything but the name palpate.
  void search_nested(const Json& value, const Path& path, const ExtrasElement& element) {
    if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        if (value[i].is_structured()) search_nested(value[i], path / i, element);
      }
      return;
    }
    for (const auto& [name, member] : value.items()) {
      const Path at = path / name;
      if (const auto rest = after_group_name(name)) {
        add(at, [&, &inner = member] {
          return "it lies inside " + in_quotes(path.text()) + "; " +
                 places_.belongs(inner, element, rest->empty());
        });
      } else if (member.is_structured()) {
        search_nested(member, at, element);
      }
    }
  }

  static constexpr std::size_t kMostKeysOfGroup = 16;

  template <typename Text>
  void add(const Path& path, const Text& text) {
    if (++count_ > kMostUnappliedLines) return;
    lines_.push_back(middle_cut(path.text()) + ": is not applied; " + text());
  }

  const GltfAsset& asset_;
  const AppliedElements& applied_;
  const KeyNames& names_;
  KeyNames::Allowance allowance_ = KeyNames::kAllowance;
  ExtrasPlaces places_;
  std::vector<std::string> lines_;
  std::size_t count_ = 0;
};

}  // namespace

std::vector<std::string> unapplied_extras(const GltfAsset& asset, const AppliedElements& applied,
                                          const KeyNames& names) {
  return Search(asset, applied, names).run();
}

}  // namespace palpate
