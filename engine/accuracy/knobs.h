#pragma once

// All knobs of the accuracy report (knob.h defines a knob), in the order of the report.

#include <vector>

#include "engine/accuracy/knob.h"
#include "engine/devices/light_device.h"
#include "engine/scene/scene.h"

namespace palpate {

// Each group is defined in its own file. The function of a group takes a device description if the
// measurements of its knobs simulate a device or depend on the encoder of the device.
std::vector<Knob> solver_knobs(
    const MeasurementEffort& effort);                     // iterations, tolerance, candidates
Knob narrow_phase_knob(const MeasurementEffort& effort);  // single or double precision
Knob certification_knob(const MeasurementEffort& effort);
Knob work_budget_knob(const MeasurementEffort& effort);
std::vector<Knob> mesh_knobs(const MeasurementEffort& effort);  // resolution, sphere or point proxy
// Rate, jitter, substeps, integrator.
std::vector<Knob> servo_knobs(const MeasurementEffort& effort,
                              const DeviceDescription& device = light_device());
// Estimator and window.
std::vector<Knob> velocity_knobs(const MeasurementEffort& effort,
                                 const DeviceDescription& device = light_device());
std::vector<Knob> a4_knobs(const MeasurementEffort& effort);  // elementary step
// Texture sampling, and the cost of each effect.
std::vector<Knob> effect_knobs(const MeasurementEffort& effort);

std::vector<Knob> all_knobs(const MeasurementEffort& effort,
                            const DeviceDescription& device = light_device());

}  // namespace palpate
