#include "engine/scene/merged_report.h"

#include <initializer_list>
#include <string_view>

#include "engine/scene/material_parameters.h"

namespace palpate {
namespace {

std::string joined(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) (all += part) += '\0';
  return all;
}

// Items with equal identities are reported once.
std::string identity(const HonouredParameter& p) {
  return joined({p.key, p.element, value_text(p.value), p.is_off ? "off" : "on"});
}
std::string identity(const DefaultedParameter& p) {
  return joined({p.key, value_text(p.value)});
}
std::string identity(const IgnoredParameter& p) {
  return joined({p.key, p.element, value_text(p.value), p.why});
}

template <typename T>
void append_new(const std::vector<T>& more, std::set<std::string>& known, std::vector<T>& list) {
  for (const T& item : more) {
    if (known.insert(identity(item)).second) list.push_back(item);
  }
}

}  // namespace

void MergedReport::append(const MaterialReport& more, MaterialReport& report) {
  append_new(more.honoured, honoured_, report.honoured);
  append_new(more.defaulted, defaulted_, report.defaulted);
  append_new(more.not_understood, not_understood_, report.not_understood);
}

void merge_names(const std::vector<std::string>& more, std::vector<std::string>& sorted) {
  std::set<std::string> all(sorted.begin(), sorted.end());
  all.insert(more.begin(), more.end());
  sorted.assign(all.begin(), all.end());
}

}  // namespace palpate
