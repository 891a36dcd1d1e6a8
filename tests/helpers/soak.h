#pragma once

// Long runs of tests. The environment variable PALPATE_SOAK turns a short run into a long one. The
// long runs have names that begin with "Soak." and the label slow or soak. Other environment
// variables set the length and the first scene of the long runs.

#include <cstdint>
#include <cstdlib>

namespace palpate::test {

// Returns the number in an environment variable, or `otherwise` if the variable is not set.
inline std::uint64_t from_environment(const char* name, std::uint64_t otherwise) {
  const char* text = std::getenv(name);
  return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

template <typename Count>
Count in_soak_or_else(Count in_soak, Count otherwise) {
  static const bool is_soak = std::getenv("PALPATE_SOAK") != nullptr;
  return is_soak ? in_soak : otherwise;
}

}  // namespace palpate::test
