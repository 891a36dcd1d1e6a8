#include "engine/accuracy/scene_findings.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <utility>

#include "engine/accuracy/percent.h"
#include "engine/accuracy/stiffness_chart.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/report/csv.h"
#include "engine/report/human_units.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

std::string digits_text(double value, int digits) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*g", digits, value);
  return text.data();
}

// Rounded so that the texts are in the same order as the numbers.
ComparedTexts compared_texts(double stiffness_N_per_m, double limit_N_per_m, bool is_within) {
  constexpr int kDigits = 3, kMostDigits = 15;
  const auto rounded = [](double value, int digits) {
    return std::strtod(digits_text(value, digits).c_str(), nullptr);
  };
  for (int digits = kDigits; digits <= kMostDigits; ++digits) {
    const double stiffness = rounded(stiffness_N_per_m, digits);
    const double limit = rounded(limit_N_per_m, digits);
    if ((stiffness <= limit) != is_within) continue;
    if (digits == kDigits) return {human(stiffness, "N/m"), human(limit, "N/m")};
    return {digits_text(stiffness, digits) + " N/m", digits_text(limit, digits) + " N/m"};
  }
  return {human(stiffness_N_per_m, "N/m"), human(limit_N_per_m, "N/m")};
}

// An error, or the floor if the error is below it.
std::string error_text(double error_m, double floor_m) {
  return error_m > floor_m ? human(error_m, "m") : "\u2264 " + human(floor_m, "m");
}

double motors_delay_s(const DeviceDescription& device) {
  return assumed_mechanics(device).delay.most_s;
}

// CSV

class Lines {
 public:
  void add(const std::string& what, const std::string& name, const char* quantity, double value,
           const char* unit) {
    lines_.add(what).add(printable(name)).add(quantity).add(value).add(unit).end_line();
  }
  const std::string& text() const { return lines_.text(); }

 private:
  CsvLines lines_{"what,name,quantity,value,unit"};
};

}  // namespace

ComparedTexts passivity_texts(const CouplingVerdict& v) {
  return compared_texts(v.effective_N_per_m, v.limits.passive_N_per_m, v.is_passive);
}
// Stable is below the limit: the other way round, a limit up to K is not.
ComparedTexts stability_texts(const CouplingVerdict& v) {
  ComparedTexts texts = compared_texts(v.limits.stable_N_per_m, v.effective_N_per_m, !v.is_stable);
  std::swap(texts.stiffness, texts.limit);
  return texts;
}

std::string delay_text(const DeviceDescription& d) {
  const double delay_s = wall_delay_s(d);
  return delay_s > 0.0 ? "delay at most " + human(delay_s, "s") : std::string("without delay");
}

std::string mechanics_text(const DeviceDescription& d) {
  std::ostringstream text;
  text << "mass " << human(d.mass_kg, "kg") << ", damping " << human(d.damping_Ns_per_m, "N s/m")
       << ", Coulomb friction " << human(d.coulomb_friction_N, "N") << ", encoder quantum "
       << (d.encoder_quantum_m > 0.0 ? human(d.encoder_quantum_m, "m") : "none");
  if (wall_delay_s(d) > 0.0) text << ", " << delay_text(d);
  return text.str();
}

std::string scene_csv(const SceneFindings& f) {
  Lines lines;
  for (const PresetOnScene& p : f.measured.presets) {
    const auto add = [&](const char* quantity, const Spread& spread) {
      lines.add("preset", p.name, quantity, spread.median, "ns");
    };
    add("p50", p.p50_ns);
    add("p99", p.p99_ns);
    add("worst", p.worst_ns);
    lines.add("preset", p.name, "iterations", p.iterations, "");
    lines.add("preset", p.name, "capped", static_cast<double>(p.capped_ticks), "ticks");
    lines.add("preset", p.name, "error_rms", p.rms_error_m, "m");
    lines.add("preset", p.name, "error_p99", p.p99_error_m, "m");
    lines.add("preset", p.name, "error_worst", p.worst_error_m, "m");
    lines.add("preset", p.name, "force_error_worst", p.worst_force_error_N, "N");
  }
  lines.add("preset", "all", "error_floor", f.measured.floor_m, "m");
  for (const RateTrial& t : f.measured.kept_rate.trials) {
    const std::string name = human(t.rate_Hz, "Hz");
    lines.add("rate", name, "ticks", static_cast<double>(t.ticks), "");
    lines.add("rate", name, "missed", static_cast<double>(t.missed), "");
    lines.add("rate", name, "longest_tick", static_cast<double>(t.worst_ns), "ns");
  }
  lines.add("rate", "safe", "rate", f.measured.kept_rate.rate_Hz(), "Hz");
  for (const CouplingVerdict& v : f.verdicts) {
    const std::string& name = v.surface.name;
    lines.add("surface", name, "stiffness", v.surface.coupling.stiffness_N_per_m, "N/m");
    lines.add("surface", name, "stiffness_felt", v.effective_N_per_m, "N/m");
    lines.add("surface", name, "damping", v.surface.coupling.damping_Ns_per_m, "N s/m");
    lines.add("surface", name, "passive_up_to", v.limits.passive_N_per_m, "N/m");
    lines.add("surface", name, "stable_below", v.limits.stable_N_per_m, "N/m");
    lines.add("surface", name, "is_passive", v.is_passive, "");
    lines.add("surface", name, "is_stable", v.is_stable, "");
    lines.add("surface", name, "stable_below_with_motors", v.zones.stable_N_per_m, "N/m");
    lines.add("surface", name, "calm_up_to_with_motors", v.zones.calm_N_per_m, "N/m");
  }
  return lines.text();
}

std::string scene_text(const SceneFindings& f) {
  std::ostringstream text;
  text << printable(f.path) << "\n";
  if (!f.measured.start_note.empty()) text << "  " << f.measured.start_note << "\n";
  text << "  computing times of this machine for ticks in contact, in simulated time:\n";
  for (const PresetOnScene& p : f.measured.presets) {
    text << "  " << p.name << std::string(10 - p.name.size(), ' ') << "tick "
         << human(p.p50_ns.median, "ns") << " / 99 % " << human(p.p99_ns.median, "ns")
         << " / worst " << human(p.worst_ns.median, "ns") << ", error "
         << error_text(p.rms_error_m, f.measured.floor_m) << " rms, "
         << error_text(p.worst_error_m, f.measured.floor_m) << " at worst\n";
  }
  const double rate_Hz = f.measured.kept_rate.rate_Hz();
  text << "  highest servo rate kept: "
       << (rate_Hz > 0.0 ? human(rate_Hz, "Hz") : "none of the rates tried") << "\n";
  for (const CouplingVerdict& v : f.verdicts) {
    const CouplingSettings& c = v.surface.coupling;
    const ComparedTexts texts = passivity_texts(v);
    text << "  " << printable(v.surface.name) << ": K " << texts.stiffness
         << (v.surface.relief_per_m > 0.0 ? " on its relief" : "") << ", "
         << (v.is_passive ? "passive" : "not passive");
    if (v.limits.passivity_bound == PassivityBound::kDamper) {
      text << " at any K with its damper of " << human(c.damping_Ns_per_m, "N s/m") << ", ";
    } else {
      text << " (passive up to " << texts.limit << "), ";
    }
    const ComparedTexts stability = stability_texts(v);
    text << (v.is_stable ? "stable" : "not stable") << " (";
    if (stability.stiffness != texts.stiffness) text << "K " << stability.stiffness << ", ";
    text << "stable below " << stability.limit << ")\n    with motors, whose force comes at most "
         << human(motors_delay_s(f.device), "s")
         << " after a position: " << zone_text(v.effective_N_per_m, v.zones) << "\n";
  }
  return text.str();
}

}  // namespace palpate
