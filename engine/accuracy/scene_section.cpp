#include "engine/accuracy/scene_section.h"

#include <cmath>
#include <filesystem>
#include <sstream>

#include "engine/report/csv.h"
#include "engine/report/html.h"
#include "engine/report/human_units.h"
#include "geometry/base/printable.h"

namespace palpate {
namespace {

// HTML of a table, cell by cell; the first column is text, the others are numbers.
class Table {
 public:
  explicit Table(const std::vector<std::string>& heads) {
    html_ << "<div class=\"wide\"><table><thead><tr>";
    for (std::size_t i = 0; i < heads.size(); ++i) cell("th", i, html_escaped(heads[i]));
    html_ << "</tr></thead><tbody>\n";
  }
  // Cells are HTML.
  void row(const std::vector<std::string>& cells) {
    html_ << "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i) cell("td", i, cells[i]);
    html_ << "</tr>\n";
  }
  std::string html() const { return html_.str() + "</tbody></table></div>\n"; }

 private:
  void cell(const char* tag, std::size_t column, const std::string& content) {
    html_ << "<" << tag << (column > 0 ? " class=\"number\"" : "") << ">" << content << "</" << tag
          << ">";
  }
  std::ostringstream html_;
};

std::string shown(double value, const char* unit) {
  return html_escaped(human(value, unit));
}

std::string shown(const Spread& spread, const char* unit) {
  return shown(spread.median, unit) + "<br><span class=\"spread\">[" + shown(spread.low, unit) +
         ", " + shown(spread.high, unit) + "]</span>";
}

// An error, or the floor that it is below.
std::string error_text(double error_m, double floor_m) {
  return error_m > floor_m ? human(error_m, "m") : "\u2264 " + human(floor_m, "m");
}

std::string flag(bool is_good, const char* good, const char* bad) {
  return is_good ? "<span class=\"good\">" + std::string(good) + "</span>"
                 : "<span class=\"bad\">" + std::string(bad) + "</span>";
}

std::string percent(double share) {
  return short_number(100.0 * share) + " %";
}

std::string presets_html(const SceneAccuracy& measured) {
  Table table({"preset", "tick, median", "99 %", "worst", "steps a tick", "capped", "error (rms)",
               "99 %", "worst", "force off by at most"});
  for (const PresetOnScene& p : measured.presets) {
    table.row({html_escaped(p.name), shown(p.p50_ns, "ns"), shown(p.p99_ns, "ns"),
               shown(p.worst_ns, "ns"), short_number(p.iterations), std::to_string(p.capped_ticks),
               error_text(p.rms_error_m, measured.floor_m),
               error_text(p.p99_error_m, measured.floor_m),
               error_text(p.worst_error_m, measured.floor_m), shown(p.worst_force_error_N, "N")});
  }
  std::ostringstream html;
  html << "<p>" << measured.hands << " simulated hands wander over it for " << measured.seconds
       << " s each, in contact for " << percent(measured.contact_share)
       << " of that; each preset replays what they did " << measured.repeats
       << " times. Times are those of ticks in contact: the median of the replays, and in brackets "
          "their quartiles. Errors are distances to the proxy of <em>exact</em> in the same tick; "
          "below "
       << shown(measured.floor_m, "m")
       << ", which is what a file rounds its coordinates to, they say nothing. Capped are the "
          "ticks in which the solver ran out of steps.</p>\n"
       << table.html();
  return html.str();
}

std::string rate_html(const KeptRate& kept) {
  Table table({"servo rate", "trials", "ticks", "missed deadlines", "longest tick", ""});
  for (const RateTrial& trial : kept.trials) {
    const std::string trials = std::to_string(trial.kept) + " of " + std::to_string(trial.trials);
    table.row({shown(trial.rate_Hz, "Hz"), trials, std::to_string(trial.ticks),
               std::to_string(trial.missed), shown(static_cast<double>(trial.worst_ns), "ns"),
               flag(trial.passed(), "kept", "not kept")});
  }
  std::ostringstream html;
  html << "<h3>Servo rate</h3>\n<p>Highest safe rate on this machine: <strong>"
       << (kept.rate_Hz() > 0.0 ? shown(kept.rate_Hz(), "Hz") : "none of those tried")
       << "</strong>, the smaller of two. Run at each rate for up to three moments, the haptic "
          "thread kept "
       << (kept.by_trial_Hz > 0.0 ? shown(kept.by_trial_Hz, "Hz") : "none of them")
       << ": at most one deadline in a thousand missed in most of the trials there, and at the "
          "lower rates that were tried. By computing alone, 999 of 1000 ticks fit into half a "
          "period up to "
       << shown(kept.by_computing_Hz, "Hz")
       << ". The first depends on what else this machine does: repeat it on an idle one.</p>\n"
       << table.html();
  if (!kept.realtime_note.empty()) {
    html << "<p class=\"note\">" << html_escaped(kept.realtime_note) << "</p>\n";
  }
  return html.str();
}

std::string device_text(const DeviceDescription& d) {
  std::ostringstream text;
  text << "mass " << human(d.mass_kg, "kg") << ", damping " << human(d.damping_Ns_per_m, "N s/m")
       << ", Coulomb friction " << human(d.coulomb_friction_N, "N") << ", encoder quantum "
       << (d.encoder_quantum_m > 0.0 ? human(d.encoder_quantum_m, "m") : "none");
  return text.str();
}

std::string stiffness_html(const SceneFindings& f) {
  std::ostringstream html;
  html
      << "<h3>Stiffness</h3>\n<p>Device: " << html_escaped(device_text(f.device))
      << ". Passive means that no hand ever gets more energy out of a wall than it put in (Colgate "
         "and Schenkel; Abbott and Okamura for the encoder); stable, which is wider, that the "
         "device comes to rest where it is pressed. K is the spring of a surface, B its damper; K "
         "may go up to the limit, which depends on B, the device and the rate. Sampling, the "
         "damper or the encoder sets the limit of passivity; it is 0 where B alone gives out as "
         "much as the damping of the device takes. A relief is stiffer than its K: what counts is "
         "the K felt along its steepest waves at a depth of "
      << shown(f.measured.deepest_m, "m")
      << ", which the hands exceeded in one tick of a hundred. Force shading adds to it, too, and "
         "is not counted.</p>\n";
  Table table({"surface", "K", "K felt", "B", "passive up to", "bound by", "stable below", "", ""});
  for (const CouplingVerdict& v : f.verdicts) {
    const CouplingSettings& c = v.surface.coupling;
    table.row({html_escaped(v.surface.name), shown(c.stiffness_N_per_m, "N/m"),
               shown(v.effective_N_per_m, "N/m"), shown(c.damping_Ns_per_m, "N s/m"),
               shown(v.limits.passive_N_per_m, "N/m"), name_of(v.limits.passivity_bound),
               shown(v.limits.stable_N_per_m, "N/m"), flag(v.is_passive, "passive", "not passive"),
               flag(v.is_stable, "stable", "not stable")});
  }
  html << "<p>At " << shown(f.rate_Hz, "Hz") << ":</p>\n" << table.html();
  Table rates({"servo rate", "passive up to", "stable below"});
  for (const LimitsAtRate& at : f.by_rate) {
    rates.row({shown(at.rate_Hz, "Hz"), shown(at.limits.passive_N_per_m, "N/m"),
               shown(at.limits.stable_N_per_m, "N/m")});
  }
  html << "<p>The limits of surfaces that have no stiffness of their own, at the rates that this "
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
  }
  return lines.text();
}

std::string scene_text(const SceneFindings& f) {
  std::ostringstream text;
  text << printable(f.path) << "\n";
  for (const PresetOnScene& p : f.measured.presets) {
    text << "  " << p.name << std::string(10 - p.name.size(), ' ') << "tick "
         << human(p.p50_ns.median, "ns") << " / 99 % " << human(p.p99_ns.median, "ns")
         << " / worst " << human(p.worst_ns.median, "ns") << ", error "
         << error_text(p.rms_error_m, f.measured.floor_m) << " rms, "
         << error_text(p.worst_error_m, f.measured.floor_m) << " at worst\n";
  }
  const double rate_Hz = f.measured.kept_rate.rate_Hz();
  text << "  highest safe servo rate here: "
       << (rate_Hz > 0.0 ? human(rate_Hz, "Hz") : "none of those tried") << "\n";
  for (const CouplingVerdict& v : f.verdicts) {
    const CouplingSettings& c = v.surface.coupling;
    text << "  " << printable(v.surface.name) << ": K " << human(v.effective_N_per_m, "N/m")
         << (v.surface.relief_per_m > 0.0 ? " felt on its relief" : "") << ", "
         << (v.is_passive ? "passive" : "not passive");
    if (v.limits.passivity_bound == PassivityBound::kDamper) {
      text << " (with its damper of " << human(c.damping_Ns_per_m, "N s/m") << " at no K), ";
    } else {
      text << " (passive up to " << human(v.limits.passive_N_per_m, "N/m") << "), ";
    }
    text << (v.is_stable ? "stable" : "not stable") << " (stable below "
         << human(v.limits.stable_N_per_m, "N/m") << ")\n";
  }
  return text.str();
}

}  // namespace palpate
