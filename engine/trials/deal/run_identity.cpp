#include "engine/trials/deal/run_identity.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include <nlohmann/json.hpp>

#include "engine/trials/key_hash.h"
#include "engine/trials/strict_json.h"

namespace palpate {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr int kMostVersion = 1'000'000;
constexpr int kMostUnits = 10'000;  // kMostParticipants, kMostSweepPoints

OrderedJson json_of(const RunIdentity& identity) {
  OrderedJson scenes = OrderedJson::object();
  for (const RunIdentity::SceneHashes& scene : identity.scenes) {
    scenes[scene.name] = {{"file_hash", hash_text(scene.file)},
                          {"geometry_hash", hash_text(scene.geometry)}};
  }
  OrderedJson json = {{"run", hash_text(identity.hash())},
                      {"version", identity.version},
                      {"plan", {{"name", identity.plan_name}, {"hash", hash_text(identity.plan)}}},
                      {"seed", identity.seed},
                      {words_of(identity.kind).nouns, identity.units},
                      {"operator",
                       {{"name", identity.operator_name},
                        {"version", identity.operator_version},
                        {"hash", hash_text(identity.operator_file)}}},
                      {"scenes", scenes}};
  if (!identity.strategies.empty()) json["strategies"] = identity.strategies;
  if (identity.kind != RunKind::kExperiment) json["kind"] = words_of(identity.kind).name;
  return json;
}

void read_hash(ObjectReader& reader, const char* key, std::uint64_t& hash) {
  std::string text;
  reader.text(key, text);
  if (!reader.ok()) return;
  const char* const end = text.data() + text.size();
  const auto [stop, failed] = std::from_chars(text.data(), end, hash, 16);
  if (failed == std::errc() && stop == end && hash_text(hash) == text) return;
  reader.fail(unexpected_value(reader.element_of(key), text, "16 hexadecimal digits"));
}

void read_kind(ObjectReader& reader, RunKind& kind) {
  const nlohmann::json* const found = reader.find("kind", ObjectReader::Key::kOptional);
  if (!found) return;
  std::vector<std::string_view> names;
  for (std::size_t i = 1; i < kRunKinds.size(); ++i) {
    names.push_back(kRunKinds[i].name);
    if (*found == kRunKinds[i].name) kind = static_cast<RunKind>(i);
  }
  if (kind != RunKind::kExperiment) return;
  reader.fail(unexpected_value(reader.element_of("kind"), *found,
                               "the name of a kind of run: " + joined_words(names)));
}

template <typename Read>
void read_part(ObjectReader& reader, const char* key, const Read& read) {
  const nlohmann::json* const found = reader.find(key);
  if (!found) return;
  ObjectReader part(*found, reader.element_of(key));
  read(part);
  if (auto error = part.finish()) reader.fail(*error);
}

void read_strategy_names(ObjectReader& reader, std::vector<std::string>& strategies) {
  const nlohmann::json* const found = reader.find("strategies", ObjectReader::Key::kOptional);
  if (!found) return;
  const bool is_list = found->is_array() && !found->empty() &&
                       std::all_of(found->begin(), found->end(),
                                   [](const nlohmann::json& name) { return name.is_string(); });
  if (is_list) {
    strategies = found->get<std::vector<std::string>>();
  } else {
    reader.fail(unexpected_value(reader.element_of("strategies"), *found, "a list of names"));
  }
}

std::vector<std::pair<std::string, std::string>> flat(const RunIdentity& identity) {
  std::vector<std::pair<std::string, std::string>> entries;
  const nlohmann::json json = nlohmann::json(json_of(identity)).flatten();
  for (const auto& [element, value] : json.items()) entries.emplace_back(element, value.dump());
  return entries;
}

}  // namespace

std::string version_of_palpate() {
  return PALPATE_VERSION;
}

std::uint64_t RunIdentity::hash() const {
  KeyHash key;
  key.add("run").add(version).add(plan_name).add(plan).add(seed);
  key.add(static_cast<std::uint64_t>(units)).add(operator_name);
  key.add(static_cast<std::uint64_t>(operator_version)).add(operator_file);
  for (const SceneHashes& scene : scenes) key.add(scene.name).add(scene.file).add(scene.geometry);
  for (const std::string& strategy : strategies) key.add("strategy").add(strategy);
  if (kind != RunKind::kExperiment) key.add("kind").add(words_of(kind).name);
  return key.value();
}

DealtUnits RunIdentity::dealt_units(std::string columns) const {
  return {std::string(words_of(kind).noun), units, hash(), std::move(columns)};
}

std::string RunIdentity::json() const {
  return json_of(*this).dump(2) + "\n";
}

RunIdentity identity_of(const ExperimentPlan& plan, const std::vector<ExperimentScene>& scenes) {
  RunIdentity identity = identity_of_persons(RunKind::kExperiment, plan);
  const std::size_t objects = plan.objects.size();
  for (std::size_t i = 0; i < objects; ++i) {
    std::uint64_t geometry = scenes[i].geometry_hash;
    for (std::size_t scaled = i + objects; scaled < scenes.size(); scaled += objects) {
      geometry = KeyHash().add(geometry).add(scenes[scaled].geometry_hash).value();
    }
    identity.scenes.push_back({plan.objects[i].name, scenes[i].file_hash, geometry});
  }
  for (const Strategy& strategy : plan.strategies) identity.strategies.push_back(name_of(strategy));
  return identity;
}

Result<RunIdentity> parse_identity(const std::string& text, const std::string& path) {
  const auto json = parse_strict_json(text, path);
  if (!json) return json.error();
  RunIdentity identity;
  std::uint64_t stated = 0;
  ObjectReader reader(*json, "");
  read_kind(reader, identity.kind);
  read_hash(reader, "run", stated);
  reader.text("version", identity.version);
  read_part(reader, "plan", [&](ObjectReader& plan) {
    plan.text("name", identity.plan_name);
    read_hash(plan, "hash", identity.plan);
  });
  reader.whole("seed", identity.seed, 0, (std::uint64_t{1} << 53) - 1);
  reader.whole(words_of(identity.kind).nouns, identity.units, 1, kMostUnits);
  read_part(reader, "operator", [&](ObjectReader& person) {
    person.text("name", identity.operator_name);
    person.whole("version", identity.operator_version, 1, kMostVersion);
    read_hash(person, "hash", identity.operator_file);
  });
  read_part(reader, "scenes", [&](ObjectReader& scenes) {
    for (const auto& [name, value] : (*json)["scenes"].items()) {
      read_part(scenes, name.c_str(), [&, object = name](ObjectReader& scene) {
        RunIdentity::SceneHashes hashes{object, 0, 0};
        read_hash(scene, "file_hash", hashes.file);
        read_hash(scene, "geometry_hash", hashes.geometry);
        identity.scenes.push_back(hashes);
      });
    }
  });
  read_strategy_names(reader, identity.strategies);
  auto error = reader.finish();
  if (!error && identity.hash() != stated) {
    error = Error{ErrorCode::kInvalidContent, "", "/run",
                  "is " + hash_text(stated) + "; expected " + hash_text(identity.hash()) +
                      ", the hash of the other entries",
                  "the file was changed; run the experiment again"};
  }
  if (!error) return identity;
  error->path = path;
  return *error;
}

std::optional<Error> find_difference(const RunIdentity& identity, const RunIdentity& other,
                                     const std::string& other_path) {
  const auto entries = flat(identity);
  const auto expected = flat(other);
  for (std::size_t i = 0; i < std::max(entries.size(), expected.size()); ++i) {
    const bool is_both = i < entries.size() && i < expected.size();
    if (is_both && entries[i] == expected[i]) continue;
    if (is_both && entries[i].first == "/run" && expected[i].first == "/run") continue;
    const bool is_mine = i < entries.size() && (!is_both || entries[i].first <= expected[i].first);
    const bool is_theirs =
        i < expected.size() && (!is_both || expected[i].first <= entries[i].first);
    return Error{ErrorCode::kInvalidContent, "", is_mine ? entries[i].first : expected[i].first,
                 (is_mine ? "is " + entries[i].second : std::string("is absent")) + "; expected " +
                     (is_theirs ? expected[i].second : std::string("no such entry")) + ", as in " +
                     other_path,
                 "merge the shards of one plan, run by one version of Palpate"};
  }
  return std::nullopt;
}

}  // namespace palpate
