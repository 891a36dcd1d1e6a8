#pragma once

// Reports of made-up data. Each function writes one into a folder and returns whether it did; what
// is wrong, it says on stderr.

#include <string>

namespace palpate::test {

// Of the accuracy study: the report, the table and the diagrams of made-up knobs.
bool write_accuracy_sample(const std::string& folder);

// Of an experiment with simulated operators, who have all followings and timeouts.
bool write_simulated_sample(const std::string& folder);

// Of an experiment with people, whose file has the columns that an analysis needs and the contact
// angle.
bool write_people_sample(const std::string& folder);

}  // namespace palpate::test
