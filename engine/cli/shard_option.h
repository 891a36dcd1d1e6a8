#pragma once

// The option --shard i/n.

#include <string>

#include "engine/trials/deal/dealt_run.h"
#include "geometry/base/result.h"

namespace palpate {

// Reads "i/n" with 1 <= i <= n <= kMostShards.
Result<Shard> parse_shard(const std::string& text);

}  // namespace palpate
