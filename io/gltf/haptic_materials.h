#pragma once

// The materials of MPEG_haptic_material (ISO/IEC 23090-14), and the meshes that they are bound to.
// The values are not interpreted here. Thread-safe.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "geometry/base/result.h"
#include "io/material_description.h"

namespace palpate {

// All haptic materials of an asset, in the order of its list. An error if one violates the
// extension's specification.
Result<std::vector<HapticMaterialDescription>> read_haptic_materials(
    const nlohmann::json& root, std::vector<std::string>& warnings);

// The haptic material of a mesh of the file: index into the list of the extension. The asset may
// use the extension's older name, MPEG_material_haptic.
Result<std::optional<std::uint32_t>> haptic_material_of_mesh(const nlohmann::json& root,
                                                             std::size_t mesh);

}  // namespace palpate
