#pragma once

// Checked access to values of the JSON of a glTF file: extensions, extras, and the values that
// gltf/schema.h checks.

#include <cstdint>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"

namespace palpate {

// Up to this value, 64-bit sizes are exact as doubles; buffers are far smaller.
inline constexpr std::uint64_t kMaxGltfWhole = std::uint64_t{1} << 53;

// The value if it is a whole number from 0 to kMaxGltfWhole, also in the form "3.0"; otherwise no
// value.
std::optional<std::uint64_t> whole_number(const nlohmann::json& value);

// The error "/nodes/7/mesh: is "x"; expected ...", for a value of any type.
Error gltf_expected(const std::string& element, const nlohmann::json& found,
                    const std::string& expected);

// The object extensions.<name> of an element; null if absent. An error if extensions or the
// extension is not an object. parent_element: JSON path of the object, for messages.
Result<const nlohmann::json*> find_extension(const nlohmann::json& object,
                                             const std::string& parent_element, const char* name);

// The value of a property that must be an index below count; no value if the property is absent.
// target: the section that the index refers to, for messages.
Result<std::optional<std::size_t>> optional_id(const nlohmann::json& object,
                                               const std::string& element, const char* property,
                                               const char* target, std::size_t count);

// Like optional_id(), but an absent property is an error.
Result<std::size_t> required_id(const nlohmann::json& object, const std::string& element,
                                const char* property, const char* target, std::size_t count);

// Sets value to the number of a property; keeps value if the property is absent. The number is
// finite: JSON has no other numbers, and a number that overflows a double does not parse.
std::optional<Error> read_number(const nlohmann::json& object, const std::string& element,
                                 const char* property, double& value);

// Like read_number(), but for a string.
std::optional<Error> read_text(const nlohmann::json& object, const std::string& element,
                               const char* property, std::string& value);

}  // namespace palpate
