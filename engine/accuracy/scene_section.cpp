#include "engine/accuracy/scene_section.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

#include "engine/accuracy/percent.h"
#include "engine/accuracy/stiffness_chart.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/report/csv.h"
#include "engine/report/html.h"
#include "engine/report/html_table.h"
#include "engine/report/human_units.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

std::string shown(double value, const char* unit) {
  return html_escaped(human(value, unit));
}

std::string shown(const Spread& spread, const char* unit) {
  return shown(spread.median, unit) + "<br><span class=\"spread\">[" + shown(spread.low, unit) +
         ", " + shown(spread.high, unit) + "]</span>";
}

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

std::string flag(bool is_good, const char* good, const char* bad) {
  return is_good ? "<span class=\"good\">" + std::string(good) + "</span>"
                 : "<span class=\"bad\">" + std::string(bad) + "</span>";
}

std::string zone_flag(StiffnessZone zone) {
  return flag(zone != StiffnessZone::kRefused, name_of(zone), name_of(zone));
}

double motors_delay_s(const DeviceDescription& device) {
  return assumed_mechanics(device).delay.most_s;
}

std::string presets_html(const SceneAccuracy& measured) {
  HtmlTable table({"preset", "tick, median", "99 %", "worst", "error (rms)", "99 %", "worst",
                   "force error, worst", "steps per tick", "capped"});
  for (const PresetOnScene& p : measured.presets) {
    table.row({html_escaped(p.name), shown(p.p50_ns, "ns"), shown(p.p99_ns, "ns"),
               shown(p.worst_ns, "ns"), error_text(p.rms_error_m, measured.floor_m),
               error_text(p.p99_error_m, measured.floor_m),
               error_text(p.worst_error_m, measured.floor_m), shown(p.worst_force_error_N, "N"),
               short_number(p.iterations), std::to_string(p.capped_ticks)});
  }
  std::ostringstream html;
  html << "<h3>Presets</h3>\n";
  if (!measured.start_note.empty()) {
    html << "<p class=\"note\">" << html_escaped(measured.start_note) << ".</p>\n";
  }
  html << "<p>" << measured.hands << " simulated hands wander over the scene for "
       << measured.seconds << " s each and touch it " << percent_text(measured.contact_share)
       << " of the time. Each preset replays their paths " << measured.repeats
       << " times, in simulated time. Times are computing times of this machine for ticks in "
          "contact: the median over the replays, with the "
          "quartiles in brackets. Errors are distances to the proxy of <em>exact</em> in the same "
          "tick; the rounding of the file's coordinates hides errors below "
       << shown(measured.floor_m, "m") << ". In capped ticks the solver exhausted its steps.</p>\n"
       << table.html();
  return html.str();
}

std::string rate_html(const KeptRate& kept) {
  HtmlTable table({"servo rate", "verdict", "trials", "ticks", "missed deadlines", "longest tick"},
                  2);
  for (const RateTrial& trial : kept.trials) {
    const std::string trials = std::to_string(trial.kept) + " of " + std::to_string(trial.trials);
    table.row({shown(trial.rate_Hz, "Hz"), flag(trial.passed(), "kept", "not kept"), trials,
               std::to_string(trial.ticks), std::to_string(trial.missed),
               shown(static_cast<double>(trial.worst_ns), "ns")});
  }
  std::ostringstream html;
  html << "<h3>Servo rate</h3>\n<p>Highest rate kept on this machine: <strong>"
       << (kept.rate_Hz() > 0.0 ? shown(kept.rate_Hz(), "Hz") : "none of the rates tried")
       << "</strong>, the smaller of two limits. In trials, the haptic thread kept "
       << (kept.by_trial_Hz > 0.0 ? shown(kept.by_trial_Hz, "Hz") : "no rate")
       << ": in most of up to three trials it missed at most one deadline in a thousand, there and "
          "at the lower rates tried. By computing time alone, 999 of 1000 ticks fit into half a "
          "period up to "
       << shown(kept.by_computing_Hz, "Hz")
       << ". The first limit depends on the other load of this machine: measure again on an idle "
          "one.</p>\n"
       << table.html();
  if (!kept.realtime_note.empty()) {
    html << "<p class=\"note\">" << html_escaped(kept.realtime_note) << "</p>\n";
  }
  return html.str();
}

std::string stiffness_html(const SceneFindings& f) {
  std::ostringstream html;
  html
      << "<h3>Stiffness</h3>\n<p>Device: " << html_escaped(mechanics_text(f.device))
      << ". A wall is passive if no hand ever gets more energy out of it than it put in (Colgate "
         "and "
         "Schenkel; Abbott and Okamura for the encoder). It is stable, which is a weaker "
         "condition, "
         "if the device comes to rest where it is pressed. K is the spring of a surface, B its "
         "damper. The limit of K depends on B, the device and the rate; sampling, the damper or "
         "the "
         "encoder sets the limit of passivity. That limit is 0 if B is at least the damping of the "
         "device. A relief adds to K: the effective K is that along its steepest waves, at a "
         "penetration depth of "
      << shown(f.measured.deepest_m, "m")
      << ", which the hands exceeded in one tick of a hundred. Force shading also adds to K and is "
         "not counted. With motors, the delay of "
      << shown(motors_delay_s(f.device), "s")
      << " counts, and a run refuses a surface that not even the controller holds.</p>\n";
  HtmlTable table({"surface", "passivity", "stability", "with motors", "effective K",
                   "passive up to", "limited by", "stable below", "K", "B"},
                  4);
  for (const CouplingVerdict& v : f.verdicts) {
    const CouplingSettings& c = v.surface.coupling;
    table.row({html_escaped(v.surface.name), flag(v.is_passive, "passive", "not passive"),
               flag(v.is_stable, "stable", "not stable"), zone_flag(v.zone()),
               html_escaped(passivity_texts(v).stiffness), html_escaped(passivity_texts(v).limit),
               name_of(v.limits.passivity_bound), html_escaped(stability_texts(v).limit),
               shown(c.stiffness_N_per_m, "N/m"), shown(c.damping_Ns_per_m, "N s/m")});
  }
  html << "<p>At " << shown(f.rate_Hz, "Hz") << ", " << delay_text(f.device) << ":</p>\n"
       << table.html();
  HtmlTable rates({"servo rate", "passive up to", "stable below"});
  for (const LimitsAtRate& at : f.by_rate) {
    rates.row({shown(at.rate_Hz, "Hz"), shown(at.limits.passive_N_per_m, "N/m"),
               shown(at.limits.stable_N_per_m, "N/m")});
  }
  html << "<p>Limits of the surfaces without a stiffness of their own, at the rates that this "
          "machine keeps:</p>\n"
       << rates.html();
  return html.str();
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

ReportSection scene_section(const SceneFindings& findings) {
  std::string html = presets_html(findings.measured) + rate_html(findings.measured.kept_rate) +
                     stiffness_html(findings);
  if (!findings.no_simplification.empty()) {
    html += "<p class=\"note\">The mesh was not simplified: " +
            html_escaped(findings.no_simplification) + ".</p>\n";
  }
  return {"Your scene: " + std::filesystem::path(findings.path).filename().string(), html};
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
