#pragma once

// What a tick of the god-object leaves for the next tick.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "haptics/proxy/contact.h"
#include "haptics/proxy/plane_projection.h"

namespace palpate {

// What a god-object remembers of a slide from tick to tick.
struct SlideMemory {
  bool slides = false;          // the contact slides
  double dynamic_friction = 0;  // the coefficient with which it slid last
  double excess_m = 0.0;        // lag minus the limit of the dynamic cone; negative if it sticks
};

// The faces at which a tick left the proxy, how the tick ended there, and the state of friction.
// Solver frame.
//
// Invariants: at most three faces hold the proxy; they are the first of the known faces. Only a
// face that holds the proxy may hold it by friction. A tick that was cut short was capped, a capped
// tick goes on in the next one, and a settled tick was not capped: one state says all of this. A
// tick whose work the bodies used up moves nothing, and keeps the end of the tick before it.
class ProxyRest {
 public:
  // The largest number of faces that hold a proxy.
  static constexpr std::size_t kMostHolding = 3;

  // How the last tick ended.
  enum class End : std::uint8_t {
    kNowhere,  // at no rest: the proxy has been placed, has moved freely, or has been pushed since
    kSettled,  // not capped: at a local minimum
    kWaited,   // the same, but the goal had waited for it: the next tick continues
    kCapped,   // capped, or the goal had waited and the proxy has been pushed since: it continues
    kCutShort  // capped for lack of work: the next tick repeats the last step
  };

  // Whether the proxy is where a tick left it at a local minimum.
  bool is_settled() const { return end_ == End::kSettled || end_ == End::kWaited; }
  // Whether the next tick continues the last one.
  bool goes_on() const { return end_ >= End::kWaited; }
  // Whether the next tick begins with the planes of the last one and repeats its last step.
  bool is_cut_short() const { return end_ == End::kCutShort; }
  End end() const { return end_; }

  // The faces that hold the proxy.
  std::span<const FaceContact> holding() const {
    return std::span(contacts_).first(holding_count_);
  }
  // These faces and the others that the next tick should know.
  std::span<const FaceContact> known() const { return std::span(contacts_).first(count_); }
  std::span<FaceContact> known() { return std::span(contacts_).first(count_); }

  // Whether the i-th face that holds the proxy has friction, and whether any has.
  bool holds_by_friction(std::size_t i) const { return by_friction_[i]; }
  bool has_friction() const { return by_friction_[0] || by_friction_[1] || by_friction_[2]; }
  const SlideMemory& slide() const { return slide_; }

  // The proxy has been placed: nothing is known of its surroundings.
  void place() {
    end_ = End::kNowhere;
    count_ = holding_count_ = 0;
    forget_friction();
  }
  // The tick moved a proxy that no face held straight to its goal.
  void move_freely() { end_ = End::kNowhere; }
  // The proxy is at rest. goal_waits: the tick had the same goal as the last one, which had not
  // settled there at once.
  void settle(bool goal_waits) { end_ = goal_waits ? End::kWaited : End::kSettled; }
  // The tick was capped. is_cut_short: for lack of work.
  void cap(bool is_cut_short) { end_ = is_cut_short ? End::kCutShort : End::kCapped; }
  // A body has pushed the proxy or has moved one of the known faces.
  void disturb() {
    if (end_ == End::kSettled) end_ = End::kNowhere;
    if (goes_on()) end_ = End::kCapped;
  }
  // The next tick does not repeat the last step, since that step was in another plane of motion.
  void drop_step() {
    if (end_ == End::kCutShort) end_ = End::kCapped;
  }

  // Stores the contacts of the active planes and, after a capped tick, those of all other planes.
  // contacts: of the planes that were projected onto.
  void keep_contacts(std::span<const FaceContact> contacts, const PlaneProjection& projection,
                     bool capped) {
    const auto active =
        std::span(projection.active).first(static_cast<std::size_t>(projection.active_count));
    count_ = 0;
    for (const int i : active) contacts_[count_++] = contacts[static_cast<std::size_t>(i)];
    holding_count_ = count_;
    if (!capped) return;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const bool is_active =
          std::find(active.begin(), active.end(), static_cast<int>(i)) != active.end();
      if (!is_active) contacts_[count_++] = contacts[i];
    }
  }

  // The state of friction at the end of the tick: which of the faces that hold the proxy have
  // friction, and the slide.
  void end_with_friction(const std::array<bool, kMostHolding>& by_friction,
                         const SlideMemory& slide) {
    by_friction_ = by_friction;
    slide_ = slide;
  }
  // The tick is without friction.
  void forget_friction() { end_with_friction({}, {}); }
  // The present contact sticks like a new one.
  void end_slide() { slide_ = {}; }

 private:
  End end_ = End::kNowhere;
  std::array<FaceContact, kMaxContactPlanes> contacts_{};
  std::size_t count_ = 0;
  std::size_t holding_count_ = 0;
  std::array<bool, kMostHolding> by_friction_{};
  SlideMemory slide_;
};

}  // namespace palpate
