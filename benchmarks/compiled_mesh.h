#pragma once

#include <optional>
#include <string>

#include "engine/scene/scene.h"
#include "models/primitives.h"

namespace palpate::bench {

// A scene of one mesh, for a proxy of proxy_radius_m; nullopt if it could not be compiled.
std::optional<Scene> compile_mesh(const std::string& name, TriangleMesh mesh,
                                  double proxy_radius_m);

}  // namespace palpate::bench
