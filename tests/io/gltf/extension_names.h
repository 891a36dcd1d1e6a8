#pragma once

// Names of glTF extensions that several tests declare.

namespace palpate::test {

inline constexpr const char* kHaptic = "MPEG_haptic_material";

}  // namespace palpate::test
