#pragma once

// The long runs of tests are those of the short ones, with PALPATE_SOAK in the environment: there
// under names that begin with "Soak.", label slow or soak. Other variables say how long, and where
// they begin.

#include <cstdint>
#include <cstdlib>

namespace palpate::test {

// The number that a variable of the environment has, or otherwise.
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
