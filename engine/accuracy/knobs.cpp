#include "engine/accuracy/knobs.h"

#include <iterator>
#include <utility>

namespace palpate {

std::vector<Knob> all_knobs(const MeasurementEffort& effort, const DeviceDescription& device) {
  std::vector<Knob> all;
  const auto add = [&](std::vector<Knob> knobs) {
    all.insert(all.end(), std::make_move_iterator(knobs.begin()),
               std::make_move_iterator(knobs.end()));
  };
  add(mesh_knobs(effort));
  add(solver_knobs(effort));
  add({narrow_phase_knob(effort), certification_knob(effort), work_budget_knob(effort)});
  add(servo_knobs(effort, device));
  add(velocity_knobs(effort, device));
  add(a4_knobs(effort));
  add(effect_knobs(effort));
  return all;
}

}  // namespace palpate
