#pragma once

// Values of the JSON of a glTF file that nothing has checked yet: extensions and extras, and what
// the schema is made of.

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// Sizes in 64 bits stay exact as doubles up to here; buffers are far smaller.
inline constexpr std::uint64_t kMaxGltfWhole = std::uint64_t{1} << 53;

// A whole number from 0 to kMaxGltfWhole, also one that is written "3.0".
std::optional<std::uint64_t> whole_number(const nlohmann::json& value);

// "/nodes/7/mesh: is "x"; expected ...", whatever the value is.
Error gltf_expected(const std::string& element, const nlohmann::json& found,
                    const std::string& expected);

// The object that an element carries as extensions.<name>; null if there is none. An error if
// either is not an object. parent_element: of the object, for messages.
Result<const nlohmann::json*> find_extension(const nlohmann::json& object,
                                             const std::string& parent_element, const char* name);

// An index below count, named by a property of an object; nothing if the property is not there.
// target: the section that it points into, for messages.
Result<std::optional<std::size_t>> optional_id(const nlohmann::json& object,
                                               const std::string& element, const char* property,
                                               const char* target, std::size_t count);

// The same where it must be there.
Result<std::size_t> required_id(const nlohmann::json& object, const std::string& element,
                                const char* property, const char* target, std::size_t count);

// Overwrites value with the number that a property has; leaves it if the property is not there.
// JSON has no number that is not finite, and what overflows a double does not parse.
std::optional<Error> read_number(const nlohmann::json& object, const std::string& element,
                                 const char* property, double& value);

// The same for a text.
std::optional<Error> read_text(const nlohmann::json& object, const std::string& element,
                               const char* property, std::string& value);

}  // namespace palpate
