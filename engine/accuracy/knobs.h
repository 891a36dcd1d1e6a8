#pragma once

// All knobs, in the order of the report.

#include <vector>

#include "engine/accuracy/knob.h"
#include "engine/devices/light_device.h"
#include "engine/scene/scene.h"

namespace palpate {

// One file per group. Knobs that simulate a device, or assume its encoder, take its description.
std::vector<Knob> solver_knobs(
    const MeasurementEffort& effort);                     // iterations, tolerance, candidates
Knob narrow_phase_knob(const MeasurementEffort& effort);  // float against double
Knob certification_knob(const MeasurementEffort& effort);
Knob work_budget_knob(const MeasurementEffort& effort);
std::vector<Knob> mesh_knobs(const MeasurementEffort& effort);  // resolution, sphere against point
// Rate, jitter, substeps, integrator.
std::vector<Knob> servo_knobs(const MeasurementEffort& effort,
                              const DeviceDescription& device = light_device());
// Estimator and window.
std::vector<Knob> velocity_knobs(const MeasurementEffort& effort,
                                 const DeviceDescription& device = light_device());
std::vector<Knob> a4_knobs(const MeasurementEffort& effort);      // elementary step
std::vector<Knob> effect_knobs(const MeasurementEffort& effort);  // texture sampling, marginal cost

std::vector<Knob> all_knobs(const MeasurementEffort& effort,
                            const DeviceDescription& device = light_device());

}  // namespace palpate
