#include "tests/engine/accuracy/sample_knobs.h"

#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "engine/report/human_units.h"
#include "geometry/base/random.h"

namespace palpate::test {
namespace {

// The figures of a level without noise.
struct Truth {
  double error;
  double time;
  double iterations = 2.0;
};

std::function<Sample(std::uint64_t)> measuring(const Truth& truth, double noise,
                                               const std::string& failure = "") {
  return [=](std::uint64_t seed) {
    SeededRandom random(seed);
    Sample sample;
    sample.error = truth.error * std::exp(noise * random.normal());
    sample.time = truth.time * std::exp(0.3 * noise * random.normal());
    sample.iterations = truth.iterations;
    sample.ticks = 1000;
    // "~" marks a level that is unstable only in some repeats.
    if (!failure.empty() && (failure.front() != '~' || random.uniform(0.0, 1.0) < 0.3)) {
      sample.failure = failure.substr(failure.front() == '~' ? 1 : 0);
    }
    return sample;
  };
}

// The presets as factors of error and time on one truth.
void give_presets(Knob& knob, const Truth& balanced, double noise, bool fast_fails = false) {
  knob.run_preset = [=](std::uint64_t seed, const Accuracy& preset) {
    const bool is_fast = preset.iterations == Accuracy::fast().iterations;
    const bool is_exact = preset.iterations == Accuracy::exact().iterations;
    Truth truth = balanced;
    truth.error *= is_fast ? 4.0 : is_exact ? 0.5 : 1.0;
    truth.time *= is_fast ? 0.8 : is_exact ? 1.5 : 1.0;
    return measuring(truth, noise, is_fast && fast_fails ? "leaked: passed a surface" : "")(seed);
  };
}

KnobResult measured(const Knob& knob) {
  return measure(knob, {}, {});
}

Knob sample_knob(const char* name, const char* title, Quantity level, Quantity error,
                 Quantity time) {
  Knob knob;
  knob.name = name;
  knob.title = title;
  knob.level = std::move(level);
  knob.error = std::move(error);
  knob.time = std::move(time);
  knob.workload = "A point slides once round a sphere of 50 mm; K = 500 N/m, B = 1 N s/m.";
  knob.reference = "The sphere itself, in closed form.";
  knob.enough_because = "a fingertip does not notice less";
  return knob;
}

}  // namespace

KnobResult sample_mesh() {
  Knob knob = sample_knob("mesh_depth", "Mesh resolution", {"edge length", "m"},
                          {"depth error", "m"}, {"time of a tick", "ns"});
  knob.floor_is = "the stand-off of the proxy";
  for (const char* name : {"point proxy", "sphere proxy"}) {
    const bool is_sphere = name[0] == 's';
    Method method{name, {}, 2.0, is_sphere ? 2e-9 : 5e-10};
    for (int n = 2; n <= 9; ++n) {
      const double edge_m = 0.06 / (1 << n);
      const int triangles = 20 << (2 * n);
      const std::string label =
          triangles < 1000 ? std::to_string(triangles) : std::to_string(triangles / 1000) + "k";
      const Truth truth{edge_m * edge_m / 0.3, (is_sphere ? 420.0 : 150.0) * std::pow(1.12, n)};
      method.levels.push_back({edge_m, label, measuring(truth, 0.15)});
    }
    knob.methods.push_back(method);
  }
  knob.enough = 1e-6;
  knob.default_method = 1;
  knob.default_level = 5;
  knob.default_because = "a sphere does not fall into gaps, which neither error nor time shows";
  give_presets(knob, {7e-8, 760.0}, 0.05);
  return measured(knob);
}

KnobResult sample_integrator() {
  Knob knob = sample_knob("integrator", "Integrator", {"servo period", "s"},
                          {"largest distance of the path to the one that is exact", "m"},
                          {"computing for a second of contact", "us"});
  knob.floor_is = "round-off";
  struct Kind {
    const char* name;
    double order, constant, cost;
    int unstable;
  };
  for (const Kind& kind :
       {Kind{"explicit Euler", 1.0, 0.9, 40.0, 2}, Kind{"Runge-Kutta 4", 4.0, 2e4, 160.0, 1},
        Kind{"matrix exponential", 0.0, 1e-17, 75.0, 0}}) {
    Method method{kind.name, {}, kind.order, 1e-15};
    if (kind.order == 0.0) method.expected_order.reset();
    for (int n = 0; n < 6; ++n) {
      const double period_s = 0.004 / (1 << n);
      const std::string label = std::to_string(250 << n) + " Hz";
      const char* failure = n < kind.unstable ? (n == 0 ? "unstable: energy grows"
                                                        : "~unstable: "
                                                          "now and then")
                                              : "";
      const Truth truth{kind.constant * std::pow(period_s, kind.order) + 1e-17,
                        kind.cost * (1 << n)};
      method.levels.push_back({period_s, label, measuring(truth, 0.1, failure)});
    }
    knob.methods.push_back(method);
  }
  knob.enough = 1e-5;
  knob.default_method = 2;
  knob.default_level = 2;
  give_presets(knob, {1e-17, 300.0}, 0.1, true);
  return measured(knob);
}

KnobResult sample_iterations() {
  Knob knob = sample_knob("solver_iterations", "Solver iterations", {"cap on steps", ""},
                          {"largest distance of the path to that of the converged proxy", "m"},
                          {"time of a tick", "ns"});
  Method method{"projected steps", {}, -2.0, 0.0};
  for (int n = 0; n < 9; ++n) {
    const int cap = 1 << n;
    const Truth truth{n < 6 ? 3e-4 / (cap * cap) : 0.0, 134.0 * (1.0 + 0.25 * std::min(n, 6)),
                      std::min(cap, 40) * 0.6};
    method.levels.push_back({static_cast<double>(cap), std::to_string(cap), measuring(truth, 0.2)});
  }
  knob.methods.push_back(method);
  knob.enough = 1e-6;
  knob.default_level = 6;
  give_presets(knob, {0.0, 335.0}, 0.1);
  return measured(knob);
}

KnobResult sample_estimators() {
  Knob knob = sample_knob("velocity_total", "Velocity estimator", {"speed of the hand", "m/s"},
                          {"velocity error", "m/s"}, {"time of an estimate", "ns"});
  knob.levels_are_given = true;
  int place = 0;
  for (const char* name : {"backward difference", "window of 8 ticks", "window of 32 ticks",
                           "first-order filter", "adaptive window", "observer"}) {
    Method method{name, {}, {}, 0.0};
    for (const double speed : {0.0, 0.01, 0.03, 0.1, 0.3, 1.0}) {
      const double noise = 0.02 / (1.0 + place);
      const Truth truth{std::hypot(noise, speed * 0.02 * place), 3.0 + 2.5 * place};
      method.levels.push_back({speed, human(speed, "m/s"), measuring(truth, 0.2)});
    }
    knob.methods.push_back(method);
    ++place;
  }
  knob.enough = 0.005;
  knob.default_method = 1;
  knob.default_level = 3;
  give_presets(knob, {0.01, 5.5}, 0.1);
  return measured(knob);
}

KnobResult sample_without_error() {
  Knob knob = sample_knob("candidate_reuse", "Candidates from tick to tick", {"reuse", ""},
                          {"depth error", "m"}, {"time of a tick", "ns"});
  Method method{"point proxy", {}, {}, 0.0};
  method.levels.push_back({1.0, "searched each tick", measuring({0.0, 171.0}, 0.05)});
  method.levels.push_back({2.0, "reused", measuring({0.0, 166.0}, 0.05)});
  knob.methods.push_back(method);
  knob.default_level = 1;
  give_presets(knob, {0.0, 166.0}, 0.05);
  return measured(knob);
}

KnobResult sample_arithmetic() {
  Knob knob = sample_knob("narrow_phase", "Arithmetic", {"bits of a coordinate", ""},
                          {"depth error", "m"}, {"time of a tick", "us"});
  knob.floor_is = "the last bit of a double";
  Method method{"a sphere that is pushed about on an object with a long name", {}, {}, 1e-14};
  method.levels.push_back({24.0, "single precision", measuring({6e-9, 1.34}, 0.2)});
  method.levels.push_back({53.0, "double precision", measuring({1e-15, 1.51}, 0.2)});
  method.levels.push_back(
      {113.0, "quadruple precision", measuring({0, 0}, 0.0, "no tick in contact")});
  knob.methods.push_back(method);
  knob.enough = 1e-10;
  knob.default_level = 1;
  give_presets(knob, {1e-15, 1.5}, 0.2);
  return measured(knob);
}

KnobResult sample_hostile(const std::string& command) {
  const std::string nasty = "<script>alert(1)</script> & \"quotes\", 'single'\ncommas, `" +
                            command + "` \\ @x $y ${z} \xff";
  Knob knob = sample_knob("hostile", "", {"", "m"}, {"", "m"}, {"", "ns"});
  for (std::string* text : {&knob.name, &knob.title, &knob.level.name, &knob.error.name,
                            &knob.time.name, &knob.workload, &knob.reference, &knob.floor_is,
                            &knob.enough_because, &knob.default_because}) {
    *text = nasty;
  }
  Method method{nasty, {}, 1.0, 1e-9};
  for (int n = 0; n < 4; ++n) {
    const double size = 1e-3 / (1 << n);
    method.levels.push_back(
        {size, nasty, measuring({size, 100.0 * (1 << n)}, 0.1, n == 0 ? nasty : "")});
  }
  knob.methods.push_back(method);
  knob.enough = 1e-4;
  knob.default_level = 3;
  give_presets(knob, {1e-4, 900.0}, 0.1);
  return measured(knob);
}

std::vector<KnobResult> all_samples() {
  return {sample_mesh(),          sample_integrator(), sample_iterations(),   sample_estimators(),
          sample_without_error(), sample_arithmetic(), sample_hostile("true")};
}

}  // namespace palpate::test
