#pragma once

// Reports of made-up data. Each function writes one into a folder and returns whether it did; what
// is wrong, it says on stderr.

#include <string>

namespace palpate::test {

// Of the accuracy study: the report, the table and the diagrams of made-up knobs.
bool write_accuracy_sample(const std::string& folder);

}  // namespace palpate::test
