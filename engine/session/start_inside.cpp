#include "engine/session/start_inside.h"

namespace palpate {
namespace {

constexpr unsigned kObjectShift = 32;

std::uint64_t packed(StartInside::Phase phase, std::uint32_t object) {
  return std::uint64_t{object} << kObjectShift | static_cast<std::uint64_t>(phase);
}

}  // namespace

StartInside::StartInside(const Scene& scene, bool stays)
    : surfaces_(scene),
      search_(surfaces_.of_objects()),
      wants_to_stay_(stays),
      published_(packed(Phase::kSearching, object_)) {
  if (!surfaces_.are_none()) return;
  has_ended_ = true;
  publish(Phase::kOutside);
}

StartInside::Status StartInside::status() const noexcept {
  const std::uint64_t all = published_.load(std::memory_order_acquire);
  const auto object = static_cast<std::uint32_t>(all >> kObjectShift);
  const bool was_inside = object != EnclosingBodySearch::kNone;
  return {static_cast<Phase>(all & 0xff), was_inside ? object : 0, was_inside};
}

void StartInside::publish(Phase phase) noexcept {
  published_.store(packed(phase, object_), std::memory_order_release);
}

void StartInside::before_tick(double /*time_s*/, LoopChanges loop) noexcept {
  if (has_ended_) return;
  if (!has_begun_) {
    has_begun_ = true;
    return loop.free_hand();
  }
  search(loop);
}

// The proxy of the tick before has crossed no surface since its track began.
void StartInside::search(LoopChanges loop) noexcept {
  const std::uint64_t track = loop.loop().free_track();
  if (track == 0) return;  // something has just stopped it
  if (track != track_) {
    track_ = track;
    search_.begin();
  }
  WorkMeter work(kSearchUnits);
  switch (search_.search(loop.loop().live_world(), loop.loop().proxy_solver(), work)) {
    case EnclosingBodySearch::State::kOutside:
      return end(Phase::kOutside, loop);
    case EnclosingBodySearch::State::kInside:
      object_ = search_.body();
      // Before a choice, the person is told where the hand is.
      if (wants_to_stay_.load(std::memory_order_relaxed)) return end(Phase::kStays, loop);
      return publish(Phase::kInside);
    case EnclosingBodySearch::State::kSearches:
      return;
  }
}

void StartInside::end(Phase phase, LoopChanges loop) noexcept {
  has_ended_ = true;
  loop.hold_hand();
  publish(phase);
}

std::optional<StartInside::Status> StartInsideNews::look() {
  const StartInside::Status status = start_.status();
  const bool is_news = status.phase != last_.phase || status.object != last_.object ||
                       status.was_inside != last_.was_inside;
  last_ = status;
  if (!is_news) return std::nullopt;
  return status;
}

std::string start_inside_text(const Scene& scene, std::size_t object) {
  return "the hand begins inside the closed surface of " + object_text(scene, object);
}

std::string felt_inside_text(const Scene& scene, std::size_t object) {
  return start_inside_text(scene, object) + ", which it feels from inside";
}

}  // namespace palpate
