#pragma once

// Every knob there is, in the order of the report.

#include <vector>

#include "engine/accuracy/knob.h"
#include "engine/scene/scene.h"

namespace palpate {

// Each group in a file of its own.
std::vector<Knob> solver_knobs(const StudyEffort& effort);  // iterations, tolerance, candidates
Knob narrow_phase_knob(const StudyEffort& effort);          // float against double
Knob certification_knob(const StudyEffort& effort);
Knob work_budget_knob(const StudyEffort& effort);
std::vector<Knob> mesh_knobs(const StudyEffort& effort);      // resolution, sphere against point
std::vector<Knob> servo_knobs(const StudyEffort& effort);     // rate, jitter, substeps, integrator
std::vector<Knob> velocity_knobs(const StudyEffort& effort);  // estimator and window
std::vector<Knob> a4_knobs(const StudyEffort& effort);        // elementary step
std::vector<Knob> effect_knobs(const StudyEffort& effort);    // texture sampling, marginal cost

std::vector<Knob> all_knobs(const StudyEffort& effort);

}  // namespace palpate
