#pragma once

// Whether a scene fits a device, and the size at which it does.

#include <optional>

#include "geometry/base/box.h"
#include "geometry/base/result.h"

namespace palpate {

// What a device reaches, and what the hand that explores with it needs.
struct Workspace {
  int sensors = 3;        // sensed axes: the first of A1 A2 A3
  double extent_m = 0.4;  // along each of them, > 0
  double room_m = 0.0;    // of the hand in front of what it touches, on every side
  double least_m = 0.0;   // of what the hand can follow: it presses so deep
};

// That of a hand that presses as deep as a planned one does.
Workspace hand_workspace(int sensors, double extent_m);

// An error if the scene is wider than the workspace along a sensed axis, or narrower than the hand
// presses along all of them; it names the size to fit it to, which works, or says that no size of
// three digits does and how large the workspace has to be. bounds_device: of the scene as it is
// placed. largest_extent_m: that --fit sets.
std::optional<Error> check_fits(const Workspace& workspace, const Box& bounds_device,
                                double largest_extent_m);

// The value of --fit with which the scene takes half of the workspace along the sensed axis that it
// is widest along, or what is left of a small workspace beside the room for the hand, if that is
// less. Rounded down to three digits. Nothing if the scene has no extent along any.
std::optional<double> fitting_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m);

// The same for all of the workspace but the room for the hand.
std::optional<double> largest_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m);

}  // namespace palpate
