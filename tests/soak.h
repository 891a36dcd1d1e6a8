#pragma once

// The long runs of tests are those of the short ones, with PALPATE_SOAK in the environment: there
// under names that begin with "Soak.", label slow.

#include <cstdlib>

namespace palpate::test {

template <typename Count>
Count in_soak_or_else(Count in_soak, Count otherwise) {
  static const bool is_soak = std::getenv("PALPATE_SOAK") != nullptr;
  return is_soak ? in_soak : otherwise;
}

}  // namespace palpate::test
