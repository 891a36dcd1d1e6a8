#pragma once

// Shorthand for the errors of the glTF reader. read_gltf() adds the name of the file.

#include <cstdio>
#include <string>
#include <utility>

#include "geometry/base/quoted.h"
#include "geometry/base/result.h"

namespace palpate {

inline Error gltf_error(ErrorCode code, std::string element, std::string problem,
                        std::string hint = {}) {
  return {code, {}, std::move(element), std::move(problem), std::move(hint)};
}

inline Error gltf_invalid(std::string element, std::string problem, std::string hint = {}) {
  return gltf_error(ErrorCode::kInvalidContent, std::move(element), std::move(problem),
                    std::move(hint));
}

// "/nodes/7", "/nodes/7/mesh"
inline std::string gltf_element(const std::string& section, std::size_t index,
                                const std::string& property = {}) {
  std::string element = "/" + section + "/" + std::to_string(index);
  if (!property.empty()) element += "/" + property;
  return element;
}

// A number with at most four significant digits.
inline std::string gltf_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace palpate
