#pragma once

// What commands say of a hand that begins inside a closed surface.

#include <cstddef>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/recording/recorder.h"
#include "engine/scene/scene.h"
#include "engine/session/start_inside.h"
#include "palpate/record.h"

namespace palpate {

// The kind of these events in a recording.
inline constexpr const char* kInsideEvent = "inside";

// One line for a person with a device; empty if there is nothing to say.
std::string start_inside_line(const Scene& scene, const StartInside::Status& status);
// null if the hand did not begin inside.
nlohmann::ordered_json start_inside_json(const Scene& scene, const StartInside::Status& status);

// Adds an event to a recording, which says the same and has no options; nothing for null.
void record_start_inside(Recorder* recorder, const Scene& scene, const StartInside::Status& status);
void record_simulated_start(Recorder* recorder, const Scene& scene,
                            std::optional<std::size_t> object);

// The object that encloses a simulated hand, or the begin of a path, in its first tick; no value
// if none does.
std::optional<std::size_t> object_around(const Scene& scene, const TickRecord& first);
// A warning; empty without an object.
std::string simulated_start_line(const Scene& scene, std::optional<std::size_t> object);
// The name of the node, or null.
nlohmann::ordered_json node_json(const Scene& scene, std::optional<std::size_t> object);

}  // namespace palpate
