#include "engine/study/knobs.h"

#include <iterator>
#include <utility>

namespace palpate {

std::vector<Knob> all_knobs(const StudyEffort& effort) {
  std::vector<Knob> all;
  for (const auto group : {solver_knobs, +arithmetic, mesh_knobs, servo_knobs, velocity_knobs,
                           a4_knobs, effect_knobs}) {
    std::vector<Knob> knobs = group(effort);
    all.insert(all.end(), std::make_move_iterator(knobs.begin()),
               std::make_move_iterator(knobs.end()));
  }
  return all;
}

}  // namespace palpate
