#pragma once

// All keys that extras.palpate of a material, of the scene or of a node may have.

#include "io/key_names.h"

namespace palpate {

// Contains the keys of all effects of the project, including effects that are not in this build.
// Thread-safe.
const KeyNames& extras_keys();

}  // namespace palpate
