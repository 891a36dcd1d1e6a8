#pragma once

// Parameters as files and command lines give them, of materials and of other parts of a scene:
// where they are from, how they read, and whether an effect can have them.

#include <string>
#include <string_view>

#include "geometry/base/result.h"
#include "haptics/effects/effect.h"
#include "io/material_description.h"

namespace palpate {

inline constexpr const char* kExtrasSource = "extras.palpate";
inline constexpr const char* kOverrideSource = "override";

// Where a parameter is from: one of these two.
std::string source_of(const MaterialParameter& parameter);

// In quotes, as it is.
std::string quoted_text(std::string_view text);

// As JSON writes it.
std::string value_text(const MaterialValue& value);

// A problem with a parameter of `owner` ("material \"wood\""): with an argument, if it is an
// override.
Error error_at(const std::string& owner, const MaterialParameter& parameter, std::string problem,
               std::string hint = "");

// Such a problem: "stiffness is -1; expected a number from 0 to 1e+06 N/m".
Error parameter_error(const std::string& owner, const MaterialParameter& parameter,
                      const std::string& expected);

// Of a parameter that calls for an effect which is not in this build.
Error not_built_error(const std::string& owner, const MaterialParameter& parameter,
                      std::string_view effect);
// The number that an effect keeps for a value: of a choice, its place. An Error as above.
Result<double> checked_number(const std::string& owner, const MaterialParameter& parameter,
                              const ParameterKey& key);
// "a number from 0 to 1e+06 N/m"
std::string expected_text(const ParameterKey& key);

}  // namespace palpate
