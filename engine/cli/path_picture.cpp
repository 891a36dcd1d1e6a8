#include "engine/cli/path_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <optional>
#include <sstream>
#include <string_view>

#include "engine/cli/simplified_line.h"
#include "engine/report/gnuplot.h"
#include "engine/report/human_units.h"
#include "engine/report/text_file.h"
#include "geometry/base/printable.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

// Okabe and Ito's colour-blind-safe blue and vermillion.
constexpr const char* kPathColour = "#0072B2";
constexpr const char* kContourColour = "#D55E00";

constexpr int kFontPx = 13;

// Pixels, from the top left corner. Each run has a column with two panels.
constexpr int kRunWidth = 480;
constexpr int kHeight = 816;
constexpr int kPanelLeft = 76, kPanelWidth = 384;
constexpr int kPathTop = 66, kPathHeight = 340;
constexpr int kAngleTop = 524, kAngleHeight = 190;
constexpr int kTitleMiddle = 18;
constexpr int kPathKeyTop = 458, kAngleKeyTop = 768;

constexpr double kTolerance = 0.4;         // px
constexpr double kLargestTolerance = 1e3;  // px; every curve is one segment then
constexpr double kColumn = 0.5;            // px of the time axis, in which extremes are kept
constexpr double kLeastAngle_deg = -3.0, kMostAngle_deg = 93.0;

using Curve = std::vector<PicturePoint>;

// The view of both path panels: A2 and A1 of its middle, metres, and the scale.
struct View {
  PicturePoint middle_m = PicturePoint::Zero();
  double px_per_m = 1.0;

  PicturePoint px(const Vec3& device_m) const {
    return px_per_m * (PicturePoint(device_m.y(), device_m.x()) - middle_m);
  }
};

// The contour, or the path over the surface, in the device frame as the run began.
Curve followed_m(const ExplorationRun& run) {
  Curve line;
  const ScenePose& pose = pose_before(run.records.front());
  const bool is_walk = run.contour_scene_m.empty();
  for (const Vec3& p_scene : is_walk ? run.places_scene_m : run.contour_scene_m) {
    const Vec3 p = pose.point(p_scene);
    line.emplace_back(p.y(), p.x());
  }
  return line;
}

View view_of(const std::vector<ExplorationRun>& runs) {
  PicturePoint low = PicturePoint::Constant(std::numeric_limits<double>::infinity());
  PicturePoint high = -low;
  const auto add = [&](const PicturePoint& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  };
  for (const ExplorationRun& run : runs) {
    for (const PicturePoint& p : followed_m(run)) add(p);
    for (const TickRecord& r : run.records) add({r.device_m[1], r.device_m[0]});
  }
  constexpr double kMargin = 1.12;
  PicturePoint extent = kMargin * (high - low);
  if (extent.isZero(0.0)) extent.setOnes();  // a path that is one point: any scale shows it
  return {0.5 * (low + high), std::min(kPanelWidth / extent.x(), kPathHeight / extent.y())};
}

// Tick labels at multiples of 1, 2 or 5 times a power of ten, as gnuplot's ("0" 0, "50" 50).
std::string tics(double low, double high) {
  constexpr double kMostTics = 6.0;
  const double least = (high - low) / kMostTics;
  int exponent = static_cast<int>(std::floor(std::log10(least)));
  double step = 0.0;
  for (const int digit : {1, 2, 5, 10}) {
    step = digit * std::pow(10.0, exponent);
    if (step < least) continue;
    if (digit == 10) ++exponent;
    break;
  }
  std::string text;
  for (double n = std::ceil(low / step); n * step <= high; n += 1.0) {
    std::array<char, 400> label{};
    const double value = n == 0.0 ? 0.0 : n * step;  // no -0
    std::snprintf(label.data(), label.size(), "%.*f", std::max(0, -exponent), value);
    std::array<char, 40> place{};
    std::snprintf(place.data(), place.size(), "%.17g", value);
    text += (text.empty() ? "(\"" : ", \"") + std::string(label.data()) + "\" " + place.data();
  }
  return text.empty() ? "()" : text + ")";
}

bool is_device_axis(const Vec3& axis) {
  return axis.cwiseAbs().maxCoeff() == 1.0;
}

// "A1", "A2", "A3", or the numbers of another direction.
std::string axis_name(const Vec3& axis) {
  for (int k = 0; k < 3; ++k) {
    if (std::abs(axis[k]) == 1.0) return "A" + std::to_string(k + 1);
  }
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "(%.3g, %.3g, %.3g)", axis.x() + 0.0, axis.y() + 0.0,
                axis.z() + 0.0);
  return text.data();
}

std::string angle_name(const ActuationModel& actuation) {
  if (actuation.actuators() == 0) return "contact angle (no axis is actuated)";
  if (actuation.actuators() == actuation.sensors()) {
    return "contact angle (every sensed axis is actuated)";
  }
  const Vec3& first = actuation.actuated_axis(0);
  if (actuation.actuators() == 1) {
    return "contact normal to " + axis_name(first);
  }
  const Vec3& second = actuation.actuated_axis(1);
  if (!is_device_axis(first) || !is_device_axis(second)) {
    return "contact normal to the plane across " + axis_name(first.cross(second));
  }
  const auto [low, high] = std::minmax({axis_name(first), axis_name(second)});
  return "contact normal to the plane of " + low + " and " + high;
}

// As much of a name as fits a line of the picture.
std::string shortened(const std::string& name, int width_px) {
  constexpr int kCharacterPx = 9;
  constexpr std::string_view kCut = "...";
  const auto most = static_cast<std::size_t>(width_px / kCharacterPx);
  const std::string text = printable(name);
  std::size_t characters = 0, end_of_part = text.size();
  for (std::size_t i = 0; i < text.size(); ++i) {
    if ((static_cast<unsigned char>(text[i]) & 0xc0) == 0x80) continue;
    if (characters == most - kCut.size()) end_of_part = i;
    ++characters;
  }
  return characters <= most ? text : text.substr(0, end_of_part) + std::string(kCut);
}

// The contact angle of each stretch in contact, px: time from the left, angle from 0. Each column
// keeps its first and last tick and the extremes; a loss of contact shorter than a column does not
// show.
class AngleCurve {
 public:
  explicit AngleCurve(const ExplorationRun& run) {
    const double end_s = run.records.back().time_s;
    const double px_per_s = end_s > 0.0 ? kPanelWidth / end_s : 0.0;
    for (const TickRecord& r : run.records) {
      const PicturePoint p(px_per_s * r.time_s, kPxPerDeg * r.alpha_rad * 180.0 / std::numbers::pi);
      const double column = std::floor(p.x() / kColumn);
      if (column != column_) end_column();
      column_ = column;
      if (r.contact) add(p);
    }
    end_column();
    end_stretch();
  }

  const std::vector<Curve>& stretches() const { return stretches_; }

  static constexpr double kPxPerDeg = kAngleHeight / (kMostAngle_deg - kLeastAngle_deg);

 private:
  void add(const PicturePoint& p) {
    if (!first_) first_ = least_ = most_ = p;
    if (p.y() < least_.y()) least_ = p;
    if (p.y() > most_.y()) most_ = p;
    last_ = p;
  }
  void end_column() {
    if (!first_) return end_stretch();
    std::array<PicturePoint, 4> points = {*first_, least_, most_, last_};
    std::sort(points.begin(), points.end(),
              [](const PicturePoint& a, const PicturePoint& b) { return a.x() < b.x(); });
    stretch_.insert(stretch_.end(), points.begin(), points.end());
    first_.reset();
  }
  void end_stretch() {
    if (stretch_.empty()) return;
    // A single tick would leave no mark.
    if (stretch_.back().x() - stretch_.front().x() < kColumn) {
      stretch_.emplace_back(stretch_.front().x() + kColumn, stretch_.back().y());
    }
    stretches_.push_back(std::move(stretch_));
    stretch_.clear();
  }

  double column_ = 0.0;
  std::optional<PicturePoint> first_;  // of the column; no value without contact
  PicturePoint least_, most_, last_;
  Curve stretch_;
  std::vector<Curve> stretches_;
};

// Screen coordinates of gnuplot, from 0 to 1 and upwards.
struct Screen {
  int width_px;

  std::string x(int px) const { return text(static_cast<double>(px) / width_px); }
  static std::string y(int px) { return text(1.0 - static_cast<double>(px) / kHeight); }
  static std::string text(double share) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.9g", share);
    return digits.data();
  }
};

class Script {
 public:
  Script(const std::vector<ExplorationRun>& runs, const ActuationModel& actuation, double tolerance)
      : runs_(runs),
        actuation_(actuation),
        tolerance_(tolerance),
        view_(view_of(runs)),
        unit_(display_unit(kPathHeight / view_.px_per_m, "m")),
        screen_{width_px()} {
    out_.precision(12);
    for (std::size_t i = 0; i < runs_.size(); ++i) write_data(i);
  }

  // All curves together.
  std::size_t points() const { return points_; }

  int width_px() const { return kRunWidth * static_cast<int>(runs_.size()); }

  std::string text(const std::string& scene_name) {
    out_ << "set multiplot\nset grid lc rgb '#dddddd'\nset tics nomirror scale 0.7\n"
         << "set label 1 " << gnuplot_quoted(shortened(scene_name, width_px())) << " at screen 0.5,"
         << Screen::y(kTitleMiddle) << " center font ',15'\n";
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      plot_path(i);
      if (i == 0) out_ << "unset label 1\n";
      plot_angle(i);
    }
    out_ << "unset multiplot\n";
    return out_.str();
  }

 private:
  // Columns of numbers that gnuplot draws as one line.
  void write_line(const Curve& line_px, const PicturePoint& scale, const PicturePoint& origin) {
    for (const PicturePoint& p : simplified_line(line_px, tolerance_)) {
      ++points_;
      out_ << origin.x() + scale.x() * p.x() << " " << origin.y() + scale.y() * p.y() << "\n";
    }
  }

  void write_data(std::size_t i) {
    const ExplorationRun& run = runs_[i];
    const PicturePoint scale = PicturePoint::Constant(unit_.factor / view_.px_per_m);
    const PicturePoint origin = unit_.factor * view_.middle_m;
    Curve path, followed;
    for (const TickRecord& r : run.records) path.push_back(view_.px(vec3(r.device_m)));
    for (const PicturePoint& p : followed_m(run)) {
      followed.push_back(view_.px_per_m * (p - view_.middle_m));
    }
    out_ << "$path" << i << " << EOD\n";
    write_line(path, scale, origin);
    out_ << "EOD\n$followed" << i << " << EOD\n";
    write_line(followed, scale, origin);
    if (followed.empty()) out_ << "NaN NaN\n";
    out_ << "EOD\n$angle" << i << " << EOD\n";
    const PicturePoint angle_scale(end_s(run) / kPanelWidth, 1.0 / AngleCurve::kPxPerDeg);
    const AngleCurve curve(run);
    for (const Curve& stretch : curve.stretches()) {
      write_line(stretch, angle_scale, PicturePoint::Zero());
      out_ << "\n";
    }
    if (curve.stretches().empty()) out_ << "NaN NaN\n";
    out_ << "EOD\n";
  }

  static double end_s(const ExplorationRun& run) {
    const double end_s = run.records.back().time_s;
    return end_s > 0.0 ? end_s : 1.0;
  }

  void place_panel(std::size_t i, int top, int height, int key_top) {
    const int left = kRunWidth * static_cast<int>(i) + kPanelLeft;
    out_ << "set lmargin at screen " << screen_.x(left) << "\nset rmargin at screen "
         << screen_.x(left + kPanelWidth) << "\nset tmargin at screen " << Screen::y(top)
         << "\nset bmargin at screen " << Screen::y(top + height) << "\nset key at screen "
         << screen_.x(left + kPanelWidth / 2) << "," << Screen::y(key_top)
         << " center top horizontal Left reverse samplen 2.5 spacing 1.3\n";
  }

  void plot_path(std::size_t i) {
    const PicturePoint half =
        0.5 * unit_.factor / view_.px_per_m * PicturePoint(kPanelWidth, kPathHeight);
    const PicturePoint low = unit_.factor * view_.middle_m - half;
    const PicturePoint high = unit_.factor * view_.middle_m + half;
    const bool is_walk = runs_[i].contour_scene_m.empty();
    place_panel(i, kPathTop, kPathHeight, kPathKeyTop);
    out_ << "set xrange [" << high.x() << ":" << low.x() << "]\nset yrange [" << low.y() << ":"
         << high.y() << "]\nset xtics " << tics(low.x(), high.x()) << "\nset ytics "
         << tics(low.y(), high.y()) << "\nset xlabel "
         << gnuplot_quoted(with_unit("A2", unit_.name)) << " offset 0,0.3\nset ylabel "
         << gnuplot_quoted(with_unit("A1", unit_.name)) << " offset 1,0\nset title '"
         << (runs_[i].a4 ? "with A4" : "without A4") << "' offset 0,-0.4\nplot $followed" << i
         << " with lines lw 2 lc rgb '" << kContourColour << "' title '"
         << (is_walk ? "path to follow, at the start" : "contour at the start") << "', $path" << i
         << " with lines lw 1.5 lc rgb '" << kPathColour << "' title 'path of the device'\n";
  }

  void plot_angle(std::size_t i) {
    place_panel(i, kAngleTop, kAngleHeight, kAngleKeyTop);
    out_ << "set xrange [0:" << end_s(runs_[i]) << "]\nset yrange [" << kLeastAngle_deg << ":"
         << kMostAngle_deg << "]\nset xtics " << tics(0.0, end_s(runs_[i]))
         << "\nset ytics 30\nset xlabel 'time (s)' offset 0,0.3\n"
         << "set ylabel 'contact angle (deg)' offset 1,0\nunset title\nplot $angle" << i
         << " with lines lw 1.5 lc rgb '" << kPathColour << "' title "
         << gnuplot_quoted(angle_name(actuation_)) << ", 30 with lines dt 2 lc rgb '"
         << kContourColour << "' title '30 deg'\n";
  }

  const std::vector<ExplorationRun>& runs_;
  const ActuationModel& actuation_;
  double tolerance_;
  View view_;
  DisplayUnit unit_;
  Screen screen_;
  std::ostringstream out_;
  std::size_t points_ = 0;
};

// The picture with the smallest tolerance at which it is small enough.
Result<std::string> draw_svg(const std::vector<ExplorationRun>& runs,
                             const ActuationModel& actuation, const std::string& scene_name) {
  constexpr std::size_t kMostPoints = kLargestPicture / 12;  // "L76.00,66.00 "
  for (double tolerance = kTolerance;; tolerance *= 2.0) {
    Script script(runs, actuation, tolerance);
    if (script.points() > kMostPoints && tolerance <= kLargestTolerance) continue;
    auto svg = gnuplot_svg(script.text(scene_name), script.width_px(), kHeight, kFontPx);
    if (!svg || svg->size() <= kLargestPicture || tolerance > kLargestTolerance) return svg;
  }
}

}  // namespace

Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const ActuationModel& actuation,
                                       const std::string& scene_name, const std::string& svg_path) {
  const auto svg = draw_svg(runs, actuation, scene_name);
  if (svg) return write_text_file(svg_path, *svg);
  Error error = svg.error();
  error.path = svg_path;
  if (error.code != ErrorCode::kFileUnwritable) {
    error.hint += "; the traces are complete without it";
  }
  return error;
}

}  // namespace palpate
