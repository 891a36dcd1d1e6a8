#pragma once

// What commands say of a hand that begins inside a closed surface.

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/scene/scene.h"
#include "engine/session/start_inside.h"
#include "palpate/record.h"

namespace palpate {

// One line for a person with a device; empty if there is nothing to say.
std::string start_inside_line(const Scene& scene, const StartInside::Status& status);
// null if the hand did not begin inside.
nlohmann::ordered_json start_inside_json(const Scene& scene, const StartInside::Status& status);

// The object that encloses a simulated hand, or the begin of a path, in its first tick; no value
// if none does.
std::optional<std::size_t> object_around(const Scene& scene, const TickRecord& first);
// A warning; empty without an object.
std::string simulated_start_line(const Scene& scene, std::optional<std::size_t> object);
// The name of the node, or null.
nlohmann::ordered_json node_json(const Scene& scene, std::optional<std::size_t> object);

}  // namespace palpate
