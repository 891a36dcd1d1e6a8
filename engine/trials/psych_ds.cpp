#include "engine/trials/psych_ds.h"

#include <set>

#include <nlohmann/json.hpp>

#include "engine/trials/csv_cells.h"

namespace palpate {
namespace {

using OrderedJson = nlohmann::ordered_json;

// What Cell::values states: a kind, and what follows it without the words for an empty field.
struct Values {
  std::string_view kind, rest;
  bool may_be_empty = false;
};

Values split(std::string_view values) {
  Values found;
  for (const std::string_view ending : {" or NA", " or empty"}) {
    if (!values.ends_with(ending)) continue;
    values.remove_suffix(ending.size());
    found.may_be_empty = true;
  }
  const std::size_t space = values.find(' ');
  found.kind = values.substr(0, space);
  if (space != std::string_view::npos) found.rest = values.substr(space + 1);
  return found;
}

void add_end(OrderedJson& variable, const char* key, std::string_view number) {
  if (const auto value = number_in(number)) variable[key] = *value;
}

// "0..9", "0..", ">0..10"
void add_range(OrderedJson& variable, std::string& meaning, std::string_view range) {
  const bool is_least_out = range.starts_with('>');
  if (is_least_out) range.remove_prefix(1);
  const std::size_t dots = range.find("..");
  if (dots == std::string_view::npos) return;
  add_end(variable, "minValue", range.substr(0, dots));
  add_end(variable, "maxValue", range.substr(dots + 2));
  if (is_least_out) meaning.append("; above ").append(range.substr(0, dots));
}

// "a|b|c"
OrderedJson levels_in(std::string_view names) {
  OrderedJson levels = OrderedJson::array();
  while (!names.empty()) {
    const std::size_t end = names.find('|');
    levels.push_back({{"@type", "DefinedTerm"}, {"name", names.substr(0, end)}});
    names = end == std::string_view::npos ? std::string_view() : names.substr(end + 1);
  }
  return levels;
}

OrderedJson variable_of(const DescribedColumn& column) {
  OrderedJson variable{{"@type", "PropertyValue"}, {"name", column.name}};
  std::string meaning = column.meaning;
  const Values values = split(column.values);
  if (values.kind == "whole" || values.kind == "number") {
    add_range(variable, meaning, values.rest);
  } else if (values.kind != "text") {
    variable["valueReference"] = levels_in(values.kind);
  }
  if (values.kind == "whole") meaning += "; a whole number";
  if (values.may_be_empty) meaning += "; an empty field: no value";
  if (!column.unit.empty()) variable["unitText"] = column.unit;
  variable["description"] = meaning;
  return variable;
}

}  // namespace

std::string dataset_description(const std::string& name, const std::string& description,
                                const std::vector<DescribedColumn>& columns) {
  OrderedJson variables = OrderedJson::array();
  std::set<std::string> known;
  for (const DescribedColumn& column : columns) {
    if (known.insert(column.name).second) variables.push_back(variable_of(column));
  }
  const OrderedJson json{{"@context", "https://schema.org/"},
                         {"@type", "Dataset"},
                         {"name", name},
                         {"description", description},
                         {"schemaVersion", kPsychDsVersion},
                         {"keywords", {"haptics", "contour following"}},
                         {"variableMeasured", variables}};
  return json.dump(2) + "\n";
}

std::string psych_ds_subject(int subject) {
  std::string number = std::to_string(subject);
  if (number.size() < 2) number.insert(0, "0");
  return "subject-" + number;
}

std::string psych_ds_file(int subject, std::string_view task) {
  return psych_ds_subject(subject) + "_task-" + std::string(task) + "_data.csv";
}

}  // namespace palpate
