#pragma once

// Facts that every report of a measurement states: program, processor, compiler, flags, date.

#include <string>
#include <utility>
#include <vector>

namespace palpate {

std::string compiler_name();   // "GNU 12.2.0"
std::string compiler_flags();  // as this program was built
std::string processor_name();  // as the system reports it, or "unknown"
unsigned processor_cores();
std::string today();  // "2026-11-21", UTC

// All facts, with their names.
std::vector<std::pair<std::string, std::string>> build_facts();

}  // namespace palpate
