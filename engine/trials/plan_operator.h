#pragma once

// The key `operator` of a plan.

#include <string>

#include "engine/trials/operator_file.h"
#include "engine/trials/strict_json.h"

namespace palpate {

// Reads the operator that the key names: a name of kShippedOperators, or the path of an operator
// file, relative to `folder` (empty: the current folder). The errors are those of load_operator();
// an unknown name is an error of the plan.
void read_plan_operator(ObjectReader& reader, const std::string& folder, OperatorFile& person);

}  // namespace palpate
