#include "engine/cli/start_inside_report.h"

#include <nlohmann/json.hpp>

#include "engine/session/closed_surfaces.h"
#include "haptics/record_vectors.h"

namespace palpate {

std::string start_inside_line(const Scene& scene, const StartInside::Status& status) {
  using Phase = StartInside::Phase;
  if (!status.was_inside) return {};
  switch (status.phase) {
    case Phase::kSearching:
      return {};
    case Phase::kInside:
      return start_inside_text(scene, status.object) +
             "; there is no force until it has left (--start-inside stay: it feels this surface "
             "from inside)";
    case Phase::kOutside:
      return "the hand has left " + object_text(scene, status.object) + "; force begins";
    case Phase::kStays:
      return start_inside_text(scene, status.object) +
             " and stays there (--start-inside stay); force begins";
  }
  return {};
}

nlohmann::ordered_json start_inside_json(const Scene& scene, const StartInside::Status& status) {
  using Phase = StartInside::Phase;
  if (!status.was_inside) return nullptr;
  const char* const ending = status.phase == Phase::kOutside ? "left"
                             : status.phase == Phase::kStays ? "stayed"
                                                             : "no force";
  return {{"node", scene.objects()[status.object].name}, {"ending", ending}};
}

void record_start_inside(Recorder* recorder, const Scene& scene,
                         const StartInside::Status& status) {
  using Phase = StartInside::Phase;
  if (recorder == nullptr || !status.was_inside || status.phase == Phase::kSearching) return;
  if (status.phase == Phase::kInside) {
    return recorder->add_event(
        kInsideEvent,
        start_inside_text(scene, status.object) + "; there is no force until it has left",
        Recorder::EventTime::kStart);
  }
  const std::string text =
      status.phase == Phase::kOutside
          ? "the hand has left " + object_text(scene, status.object) + "; force begins"
          : start_inside_text(scene, status.object) + " and stays there; force begins";
  recorder->add_event(kInsideEvent, text, Recorder::EventTime::kNow);
}

void record_simulated_start(Recorder* recorder, const Scene& scene,
                            std::optional<std::size_t> object) {
  if (recorder == nullptr || !object) return;
  recorder->add_event(kInsideEvent, felt_inside_text(scene, *object), Recorder::EventTime::kStart);
}

std::optional<std::size_t> object_around(const Scene& scene, const TickRecord& first) {
  if ((first.faults & kFaultsWithoutForce) != 0) return std::nullopt;
  return enclosing_object(scene, vec3(first.goal_scene_m));
}

std::string simulated_start_line(const Scene& scene, std::optional<std::size_t> object) {
  return object ? felt_inside_text(scene, *object) : std::string();
}

nlohmann::ordered_json node_json(const Scene& scene, std::optional<std::size_t> object) {
  return object ? nlohmann::ordered_json(scene.objects()[*object].name) : nlohmann::ordered_json();
}

}  // namespace palpate
