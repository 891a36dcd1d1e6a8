#include "engine/trials/sweep/sweep_points.h"

#include <algorithm>
#include <cmath>

#include "engine/trials/sweep/latin_hypercube.h"

namespace palpate {
namespace {

SweepValues values_of(const ExperimentPlan& plan) {
  SweepValues values;
  for (std::size_t i = 0; i < kSweepParameterCount; ++i) values[i] = sweep_value(plan, i);
  return values;
}

// The value at a coordinate from 0 to 1.
double value_at(const SweptParameter& swept, double coordinate) {
  if (!sweep_parameters()[swept.parameter].is_listed) {
    return swept.low + (swept.high - swept.low) * coordinate;
  }
  const auto count = static_cast<double>(swept.levels.size());
  return swept.levels[static_cast<std::size_t>(std::floor(coordinate * count))];
}

void add_hypercube(const Sweep& sweep, const SweepPoint& base, std::vector<SweepPoint>& points) {
  const std::size_t first = points.size();
  SweepPoint point = base;
  point.block = SweepBlock::kHypercube;
  point.participants = sweep.hypercube.participants;
  points.resize(first + static_cast<std::size_t>(sweep.hypercube.points), point);
  for (const SweptParameter& swept : sweep.parameters) {
    const auto coordinates = hypercube_coordinates(
        sweep.hypercube.seed, sweep_parameters()[swept.parameter].name, points.size() - first);
    for (std::size_t i = first; i < points.size(); ++i) {
      points[i].values[swept.parameter] = value_at(swept, coordinates[i - first]);
    }
  }
}

std::string settings_text(const Sweep& sweep, const SweepPoint& point) {
  std::string text;
  for (const SweptParameter& swept : sweep.parameters) {
    if (point.varied && *point.varied != swept.parameter) continue;
    text += (text.empty() ? "" : ", ") + std::string(sweep_parameters()[swept.parameter].name) +
            " " + sweep_value_text(swept.parameter, *point.values[swept.parameter]);
  }
  return text;
}

}  // namespace

std::vector<SweepPoint> sweep_points(const Sweep& sweep) {
  const SweepPoint base{SweepBlock::kBase, std::nullopt, values_of(sweep.plan),
                        sweep.plan.participants};
  std::vector<SweepPoint> points{base};
  for (const SweptParameter& swept : sweep.parameters) {
    for (const double level : swept.levels) {
      if (base.values[swept.parameter] == level) continue;
      SweepPoint point = base;
      point.block = SweepBlock::kOneAtATime;
      point.varied = swept.parameter;
      point.values[swept.parameter] = level;
      points.push_back(point);
    }
  }
  add_hypercube(sweep, base, points);
  return points;
}

ExperimentPlan plan_at(const Sweep& sweep, const SweepPoint& point) {
  ExperimentPlan plan = sweep.plan;
  plan.participants = point.participants;
  for (const SweptParameter& swept : sweep.parameters) {
    const auto& value = point.values[swept.parameter];
    if (value) set_sweep_value(plan, swept.parameter, *value);
  }
  return plan;
}

Error at_point(Error error, const Sweep& sweep, const SweepPoint& point) {
  const bool is_of_plan = error.path.empty() || error.path == sweep.plan.path;
  if (!is_of_plan) return error;
  error.path = sweep.path;
  if (point.block == SweepBlock::kBase) {
    error.element = "/plan" + error.element;
    return error;
  }
  error.problem =
      error.element + " " + error.problem + " (with " + settings_text(sweep, point) + ")";
  error.element = point.varied
                      ? "/parameters/" + std::string(sweep_parameters()[*point.varied].name)
                      : "/hypercube";
  return error;
}

}  // namespace palpate
