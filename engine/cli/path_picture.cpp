#include "engine/cli/path_picture.h"

#include <algorithm>
#include <numbers>
#include <sstream>

#include "engine/report/gnuplot.h"
#include "engine/report/text_file.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// More points than a picture has pixels across only make the file larger.
constexpr std::size_t kPointsPerCurve = 2500;

// Okabe and Ito's colour-blind-safe blue and vermillion.
constexpr const char* kPathColour = "#0072B2";
constexpr const char* kContourColour = "#D55E00";

constexpr int kRunWidthPx = 480;
constexpr int kHeightPx = 780;
constexpr int kFontPx = 13;

std::size_t stride_of(const ExplorationRun& run) {
  return std::max<std::size_t>(1, run.records.size() / kPointsPerCurve);
}

void write_path(std::ostream& out, const std::string& name, const ExplorationRun& run) {
  out << name << " << EOD\n";
  for (std::size_t i = 0; i < run.records.size(); i += stride_of(run)) {
    const Vec3& p = vec3(run.records[i].device_m);
    out << p.y() << " " << p.x() << "\n";
  }
  out << "EOD\n";
}

void write_contour(std::ostream& out, const std::string& name, const ExplorationRun& run) {
  out << name << " << EOD\n";
  const ScenePose& pose = pose_before(run.records.front());
  for (const Vec3& p_scene : run.contour_scene_m) {
    const Vec3 p = pose.point(p_scene);
    out << p.y() << " " << p.x() << "\n";
  }
  if (run.contour_scene_m.empty()) out << "NaN NaN\n";
  out << "EOD\n";
}

void write_angles(std::ostream& out, const std::string& name, const ExplorationRun& run) {
  out << name << " << EOD\n";
  for (std::size_t i = 0; i < run.records.size(); i += stride_of(run)) {
    const TickRecord& r = run.records[i];
    out << r.time_s << " ";
    if (r.contact) {
      out << r.alpha_rad * 180.0 / std::numbers::pi << "\n";
    } else {
      out << "NaN\n";
    }
  }
  out << "EOD\n";
}

std::string script(const std::vector<ExplorationRun>& runs, const std::string& scene_name) {
  std::ostringstream out;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string n = std::to_string(i);
    write_path(out, "$path" + n, runs[i]);
    write_contour(out, "$contour" + n, runs[i]);
    write_angles(out, "$angle" + n, runs[i]);
  }
  out << "set multiplot layout 2," << runs.size() << " rowsfirst title "
      << gnuplot_quoted(scene_name) << "\n"
      << "set grid lc rgb '#dddddd'\nset key below spacing 1.3\n"
      << "set size ratio -1\nset xrange [] reverse\nset offsets graph 0.05,0.05,0.05,0.05\n"
      << "set xtics 0.1\nset ytics 0.1\n"
      << "set xlabel 'A2 (m)'\nset ylabel 'A1 (m)'\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    out << "set title '" << (runs[i].a4 ? "with A4" : "without A4") << "'\n"
        << "plot $contour" << i << " with lines lw 2 lc rgb '" << kContourColour
        << "' title 'object at the start', $path" << i << " with lines lw 1.5 lc rgb '"
        << kPathColour << "' title 'path of the device'\n";
  }
  out << "set size noratio\nset xrange [*:*] noreverse\nset xtics autofreq\n"
      << "set yrange [-3:93]\nset ytics 30\n"
      << "set offsets 0,0,0,0\n"
      << "set xlabel 'time (s)'\nset ylabel 'contact angle (deg)'\nunset title\n";
  for (std::size_t i = 0; i < runs.size(); ++i) {
    out << "plot $angle" << i << " with lines lw 1.5 lc rgb '" << kPathColour
        << "' title 'normal to A1', 30 with lines dt 2 lc rgb '" << kContourColour
        << "' title '30 deg'\n";
  }
  out << "unset multiplot\n";
  return out.str();
}

}  // namespace

Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const std::string& scene_name, const std::string& svg_path) {
  const int width_px = kRunWidthPx * static_cast<int>(runs.size());
  const auto svg = gnuplot_svg(script(runs, scene_name), width_px, kHeightPx, kFontPx);
  if (svg) return write_text_file(svg_path, *svg);
  Error error = svg.error();
  error.path = svg_path;
  if (error.code != ErrorCode::kFileUnwritable) {
    error.hint += "; the traces are complete without it";
  }
  return error;
}

}  // namespace palpate
