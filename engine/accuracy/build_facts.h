#pragma once

// What a measurement must say about how it came about.

#include <string>
#include <utility>
#include <vector>

namespace palpate {

std::string compiler_name();   // "GNU 12.2.0"
std::string compiler_flags();  // as this program was built
std::string processor_name();  // as the system calls it; "unknown" if it does not say
unsigned processor_cores();
std::string today();  // "2026-11-21", UTC

// All of them, with their names.
std::vector<std::pair<std::string, std::string>> build_facts();

}  // namespace palpate
