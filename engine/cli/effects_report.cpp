#include "engine/cli/effects_report.h"

#include <cstdio>
#include <utility>
#include <variant>

#include <nlohmann/json.hpp>

#include "engine/cli/option_names.h"
#include "engine/scene/load_warnings.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

using nlohmann::ordered_json;

ordered_json value_json(const MaterialValue& value) {
  return std::visit([](const auto& v) { return ordered_json(v); }, value);
}

// One line, whatever bytes a text contains.
std::string json_text(const ordered_json& json) {
  return printable(json.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

std::string value_line(const std::string& key, const MaterialValue& value,
                       const std::string& unit) {
  return key + " " + json_text(value_json(value)) + (unit.empty() ? "" : " " + unit);
}

// A key of a file, without its quotes; it may contain any bytes.
std::string shown(const std::string& key) {
  const std::string text = json_text(key);
  return text.substr(1, text.size() - 2);
}

ordered_json parameters_json(const MaterialDescription& material) {
  ordered_json parameters = ordered_json::object();
  for (const MaterialParameter& p : material.parameters) parameters[p.key] = value_json(p.value);
  return parameters;
}

// "    defaults: a 1 m, b 2\n", or an empty text for an empty list.
template <typename List, typename Item>
std::string list_line(const char* what, const List& list, Item item) {
  std::string text;
  for (const auto& entry : list) text += (text.empty() ? "" : ", ") + item(entry);
  return text.empty() ? text : std::string("    ") + what + ": " + text + "\n";
}

// The source of a value as a user knows it: an override is the option --material.
std::string source_name(const std::string& source) {
  return source == "override" ? "--material" : source;
}

std::string report_text(const MaterialReport& report) {
  return list_line("applied", report.honoured,
                   [](const HonouredParameter& p) {
                     return value_line(p.key, p.value, p.unit) + " (" + source_name(p.source) +
                            (p.is_off ? ", off)" : ")");
                   }) +
         list_line("defaults", report.defaulted,
                   [](const DefaultedParameter& p) { return value_line(p.key, p.value, p.unit); }) +
         list_line("ignored", report.not_understood, [](const IgnoredParameter& p) {
           return value_line(shown(p.key), p.value, "") + " (" + with_option_names(p.why) + ")";
         });
}

// The file's parameters of a material, in one line.
std::string parameters_text(const MaterialDescription& material) {
  std::string text;
  const ordered_json parameters = parameters_json(material);
  for (const auto& [key, value] : parameters.items()) {
    text += (text.empty() ? ": " : ", ") + shown(key) + " " + json_text(value);
  }
  return text;
}

std::string names_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace

ordered_json declaration_json(const DeclarationReport& declaration) {
  ordered_json honoured = ordered_json::array();
  for (const HonouredParameter& p : declaration.report.honoured) {
    honoured.push_back({{"key", p.key},
                        {"value", value_json(p.value)},
                        {"unit", p.unit},
                        {"source", source_name(p.source)},
                        {"element", with_option_names(p.element)},
                        {"off", p.is_off}});
  }
  ordered_json defaulted = ordered_json::array();
  for (const DefaultedParameter& p : declaration.report.defaulted) {
    defaulted.push_back({{"key", p.key}, {"value", value_json(p.value)}, {"unit", p.unit}});
  }
  ordered_json not_understood = ordered_json::array();
  for (const IgnoredParameter& p : declaration.report.not_understood) {
    not_understood.push_back({{"key", p.key},
                              {"value", value_json(p.value)},
                              {"element", with_option_names(p.element)},
                              {"why", with_option_names(p.why)}});
  }
  return {{"effects", declaration.effects},
          {"honoured", std::move(honoured)},
          {"defaulted", std::move(defaulted)},
          {"not_understood", std::move(not_understood)}};
}

ordered_json materials_json(const Scene& scene) {
  ordered_json list = ordered_json::array();
  const auto& reports = scene.effects().materials;
  for (std::size_t i = 0; i < reports.size(); ++i) {
    const bool is_in_file = i < scene.materials().size();
    ordered_json json = {{"name", reports[i].name}};
    json["parameters"] =
        is_in_file ? parameters_json(scene.materials()[i]) : ordered_json::object();
    json.update(declaration_json(reports[i]));
    list.push_back(std::move(json));
  }
  return list;
}

ordered_json regions_json(const Scene& scene) {
  ordered_json list = ordered_json::array();
  for (const DeclarationReport& region : scene.effects().regions) {
    ordered_json json = {{"name", region.name}};
    json.update(declaration_json(region));
    list.push_back(std::move(json));
  }
  return list;
}

ordered_json effects_use_json(const RunSummary& summary, const Scene& scene) {
  ordered_json json = ordered_json::object();
  for (const std::string& effect : scene.effects().effects) {
    const std::uint16_t number = *effect_number(effect);
    json[effect]["ticks"] = summary.effect_ticks[number];
    if (summary.effect_time_shares) {
      json[effect]["time_share"] = (*summary.effect_time_shares)[number];
    }
  }
  json["a4"]["ticks"] = summary.a4_ticks;
  return json;
}

std::string declarations_text(const Scene& scene) {
  std::string text;
  const SceneEffectsReport& effects = scene.effects();
  for (std::size_t i = 0; i < effects.materials.size(); ++i) {
    const DeclarationReport& m = effects.materials[i];
    const std::string parameters =
        i < scene.materials().size() ? parameters_text(scene.materials()[i]) : "";
    if (m.report.empty() && parameters.empty()) continue;
    text += "  material " + json_text(m.name) + parameters + "\n" + report_text(m.report);
  }
  if (!effects.scene.report.empty()) text += "  scene\n" + report_text(effects.scene.report);
  for (const DeclarationReport& region : effects.regions) {
    text += "  region " + json_text(region.name) + "\n" + report_text(region.report);
  }
  return text + "  effects: " + names_text(effects.effects) + "\n";
}

std::string effect_use_text(const RunSummary& summary, std::string_view effect) {
  const std::uint16_t number = *effect_number(effect);
  std::string text = std::to_string(summary.effect_ticks[number]) + " ticks";
  if (!summary.effect_time_shares) return text;
  char share[32];
  std::snprintf(share, sizeof share, ", %.1f %% of the time",
                100 * (*summary.effect_time_shares)[number]);
  return text + share;
}

std::vector<std::string> not_understood_lines(const Scene& scene) {
  return with_option_names(unapplied_lines(scene));
}

std::vector<std::string> load_warning_lines(const Scene& scene) {
  return with_option_names(load_warnings(scene));
}

}  // namespace palpate
