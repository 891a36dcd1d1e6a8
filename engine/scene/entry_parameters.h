#pragma once

// Reads and writes the parameters that an entry of an effect program stores as bytes.

#include <cstring>

#include "haptics/effects/effect_program.h"

namespace palpate {

template <typename Parameters>
Parameters read_parameters(const EffectProgramBuilder::Entry& entry) {
  Parameters parameters;
  std::memcpy(&parameters, entry.parameters.data(), sizeof parameters);
  return parameters;
}

template <typename Parameters>
void write_parameters(const Parameters& parameters, EffectProgramBuilder::Entry& entry) {
  entry.parameters.resize(sizeof parameters);
  std::memcpy(entry.parameters.data(), &parameters, sizeof parameters);
}

}  // namespace palpate
