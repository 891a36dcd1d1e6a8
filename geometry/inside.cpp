#include "geometry/inside.h"
namespace palpate {
std::optional<bool> is_inside(const SurfaceIndex&, const Vec3&) noexcept { return {}; }
std::optional<bool> crosses_odd(const SurfaceIndex&, const Vec3&, const Vec3&) noexcept { return {}; }
}
