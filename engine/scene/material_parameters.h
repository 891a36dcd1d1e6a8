#pragma once

// Handles the parameters of materials, of the scene and of nodes, which come from files and command
// lines: states their source and their text, and checks their values.

#include <string>
#include <string_view>

#include "geometry/base/result.h"
#include "haptics/effects/effect.h"
#include "io/material_description.h"

namespace palpate {

inline constexpr const char* kExtrasSource = "extras.palpate";
inline constexpr const char* kOverrideSource = "override";

// The source of a parameter: kExtrasSource or kOverrideSource.
std::string source_of(const MaterialParameter& parameter);

// Returns the text in quotation marks, with no character escaped.
std::string quoted_text(std::string_view text);

// The value in JSON notation.
std::string value_text(const MaterialValue& value);

// An error about a parameter of `owner` ("material \"wood\""). The code is kInvalidArgument for an
// override and kInvalidContent otherwise.
Error error_at(const std::string& owner, const MaterialParameter& parameter, std::string problem,
               std::string hint = "");

// error_at() for a wrong value, e.g. "stiffness is -1; expected a number from 0 to 1e+06 N/m".
Error parameter_error(const std::string& owner, const MaterialParameter& parameter,
                      const std::string& expected);

// The error for a parameter that requires an effect which is not in this build.
Error not_built_error(const std::string& owner, const MaterialParameter& parameter,
                      std::string_view effect);

// The number that the effect stores for a value. For a choice, this number is the index of the
// choice in ParameterKey::choices. Returns a parameter_error() if the value is not allowed.
Result<double> checked_number(const std::string& owner, const MaterialParameter& parameter,
                              const ParameterKey& key);

// The value of a key that is true or false. The numbers 1 and 0 stand for them, because panels for
// custom properties write them so. Returns a parameter_error() for another value.
Result<bool> checked_flag(const std::string& owner, const MaterialParameter& parameter);

// The allowed values of a key, e.g. "a number from 0 to 1e+06 N/m".
std::string expected_text(const ParameterKey& key);

}  // namespace palpate
