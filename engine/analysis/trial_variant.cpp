#include "engine/analysis/trial_variant.h"

#include "engine/trials/as_printed.h"

namespace palpate {

std::string variant_name(const TrialVariant& variant, const TrialVariant& plain) {
  std::string name;
  const auto add = [&](const std::string& text) { name += (name.empty() ? "" : ", ") + text; };
  if (variant.view != plain.view) add("view " + variant.view);
  if (variant.align != plain.align) add("align " + variant.align);
  if (variant.start_orientation_deg != plain.start_orientation_deg) {
    add("start " + as_printed(variant.start_orientation_deg) + " deg");
  }
  if (variant.scale != plain.scale) add("scale " + as_printed(variant.scale));
  return name;
}

}  // namespace palpate
