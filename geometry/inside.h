#pragma once
#include <optional>
#include "geometry/surface_index.h"
namespace palpate {
std::optional<bool> is_inside(const SurfaceIndex& index, const Vec3& p) noexcept;
std::optional<bool> crosses_odd(const SurfaceIndex& index, const Vec3& p, const Vec3& q) noexcept;
}
