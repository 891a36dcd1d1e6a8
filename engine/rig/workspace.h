#pragma once

// Checks whether a scene fits a device, and computes the size at which it fits.

#include <optional>

#include "engine/scene/scene.h"
#include "engine/session/run_setup.h"
#include "geometry/base/box.h"
#include "geometry/base/result.h"

namespace palpate {

// The depth of a hand's target inside the wall that it presses: about 0.5 N.
inline constexpr double kHandPressDepth_m = 4e-3;

// The range of a device and the clearance that the exploring hand needs.
struct Workspace {
  int sensors = 3;        // number of sensed axes, A1 first
  double extent_m = 0.4;  // range along each sensed axis, > 0
  double room_m = 0.0;    // clearance for the hand on each side of the scene
  double least_m = 0.0;   // smallest extent that the hand can follow: its press depth
};

// The workspace for a hand with this press depth.
Workspace hand_workspace(int sensors, double extent_m);
// That of the setup's device.
Workspace hand_workspace(const RunSetup& setup);

// Returns an error if the scene is larger than the workspace along a sensed axis, or smaller than
// the press depth along all sensed axes. The error names a size to scale the scene to. If no size
// of three digits fits the workspace, the error states instead how large the workspace must be.
// bounds_device: bounds of the placed scene. largest_extent_m: the extent that --fit sets.
std::optional<Error> check_fits(const Workspace& workspace, const Box& bounds_device,
                                double largest_extent_m);

// The value of --fit that scales the scene's largest extent along a sensed axis to half of the
// workspace, or to the workspace less the clearance for the hand if that is smaller. The value is
// rounded down to three digits. Returns no value if the scene has no extent along any sensed axis.
std::optional<double> fitting_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m);

// The same for a scene in its pose at the start, RunSetup::haptics.initial_pose. Nothing is wrong
// with an empty scene.
std::optional<Error> check_fits(const Scene& scene, const RunSetup& setup);
// The scene must have a surface.
std::optional<double> fitting_size_m(const Scene& scene, const RunSetup& setup);

// Like the first fitting_size_m(), but scales the scene to the whole workspace less the clearance
// for the hand.
std::optional<double> largest_size_m(const Workspace& workspace, const Box& bounds_device,
                                     double largest_extent_m);

}  // namespace palpate
