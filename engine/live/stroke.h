#pragma once

// How far a device must reach for a trial. A4 unrolls a contour into one long stroke.

#include <optional>

#include "engine/devices/light_device.h"
#include "engine/trials/experiment_scene.h"
#include "engine/trials/plan.h"
#include "geometry/base/box.h"
#include "geometry/base/result.h"

namespace palpate {

// The smallest box, relative to the device point at the start of a trial, in which the simulated
// hand of a participant stays with this object in all conditions of the plan, device frame. The
// hand feels no force, so that it also goes where a wall would hold it back. Errors: those of
// run_trial().
Result<Box> find_stroke(const ExperimentPlan& plan, const ExperimentScene& scene, int participant);

// The places from which a stroke stays in the workspace of the device; no value: there are none.
std::optional<Box> start_region(const Box& stroke, const DeviceDescription& device);

// An error if the workspace is too small for the stroke, with the factor of the object's size that
// fits. object: its name. scale: the present factor.
std::optional<Error> check_stroke(const Box& stroke, const DeviceDescription& device,
                                  const ExperimentPlan& plan, const std::string& object,
                                  double scale);

}  // namespace palpate
