#pragma once

// What a session with a person does if the hand begins inside a closed surface.

#include <atomic>
#include <cstdint>
#include <optional>

#include "engine/session/closed_surfaces.h"
#include "engine/session/haptic_session.h"
#include "haptics/enclosure_search.h"

namespace palpate {

// At first the hand is free (HapticLoop::free_hand()). Force begins when the hand is outside of all
// closed surfaces, at a place that touches nothing, or when the person chooses to stay inside, as
// in a room. Where nothing is closed, the hand is never free.
//
// On the haptic thread, a tick of a free hand searches for the bodies that enclose the proxy, with
// a bound on its work; the search goes on in later ticks as long as the proxy crosses no surface
// (HapticLoop::free_track()). All changes go through LoopChanges: a recording holds them, and its
// replay needs no search. List it after all objects that move nodes.
class StartInside final : public BeforeTick {
 public:
  enum class Phase : std::uint8_t {
    kSearching,  // no force, until it is known where the hand is
    kInside,     // no force, until the hand has left or stays
    kOutside,    // the hand was outside, or has left
    kStays       // the person has chosen to stay
  };
  struct Status {
    Phase phase = Phase::kSearching;
    std::uint32_t object = 0;  // of the scene: the newest one that enclosed the hand
    bool was_inside = false;   // object is valid
  };

  // stays: the choice of before the start. The scene must outlive this object.
  StartInside(const Scene& scene, bool stays);

  // Any thread may call these functions.
  void stay() noexcept { wants_to_stay_.store(true, std::memory_order_relaxed); }
  Status status() const noexcept;

  void before_tick(double time_s, LoopChanges loop) noexcept override;

  // The work of a search in one tick: about a twentieth of the default work budget.
  static constexpr WorkUnits kSearchUnits = 1000;

 private:
  void search(LoopChanges loop) noexcept;
  void end(Phase phase, LoopChanges loop) noexcept;
  void publish(Phase phase) noexcept;

  ClosedSurfaces surfaces_;
  EnclosingBodySearch search_;
  std::uint64_t track_ = 0;
  bool has_begun_ = false;
  bool has_ended_ = false;
  std::uint32_t object_ = EnclosingBodySearch::kNone;
  std::atomic<bool> wants_to_stay_;
  std::atomic<std::uint64_t> published_;  // the phase, then the object
};

// Tells each change of the status once. One thread may use it; the StartInside must outlive it.
class StartInsideNews {
 public:
  explicit StartInsideNews(const StartInside& start) : start_(start) {}
  // The status if it is news.
  std::optional<StartInside::Status> look();

 private:
  const StartInside& start_;
  StartInside::Status last_;
};

// That the hand begins inside an object.
std::string start_inside_text(const Scene& scene, std::size_t object);
// The same of a hand without a person, whose force nothing holds back.
std::string felt_inside_text(const Scene& scene, std::size_t object);

}  // namespace palpate
