#include "engine/cli/path_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <string_view>
#include <utility>

#include "engine/cli/simplified_line.h"
#include "engine/report/human_units.h"
#include "engine/report/svg.h"
#include "engine/report/text_file.h"
#include "geometry/base/printable.h"
#include "haptics/record_vectors.h"

namespace palpate {
namespace {

constexpr int kFontPx = 13, kTitlePx = 15;

// Pixels, from the top left corner. Each run has a column with two panels.
constexpr int kRunWidth = 480;
constexpr int kHeight = 816;
constexpr int kPanelLeft = 76, kPanelWidth = 384;
constexpr int kPathTop = 66, kPathHeight = 340;
constexpr int kAngleTop = 524, kAngleHeight = 190;
constexpr int kTitleLine = 23, kHeadGap = 16;
constexpr int kPathKeyTop = 471, kAngleKeyTop = 781;
constexpr int kKeyLeft = 108, kKeySample = 33, kKeyGap = 8, kKeyDrop = 5, kKeyLine = 25;

constexpr double kTolerance = 0.4;         // px
constexpr double kLargestTolerance = 1e3;  // px; every curve is one segment then
constexpr double kColumn = 0.5;            // px of the time axis, in which extremes are kept
constexpr double kLeastAngle_deg = -3.0, kMostAngle_deg = 93.0;
constexpr double kTurnFrom_deg = 30.0;  // the angle that a line marks

using Curve = std::vector<PicturePoint>;

// The view of both path panels: A2 and A1 of its middle, metres, and the scale.
struct View {
  PicturePoint middle_m = PicturePoint::Zero();
  double px_per_m = 1.0;
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

// A panel of a run: its area, and the key below it.
SvgBox panel_area(std::size_t run, int top, int height) {
  const double left = kRunWidth * static_cast<double>(run) + kPanelLeft;
  return {left, static_cast<double>(top), left + kPanelWidth, static_cast<double>(top + height)};
}

struct KeyLine {
  std::string words;
  SvgStroke stroke;
};

constexpr SvgStroke kPathStroke{kSvgBlue, 1.5};
constexpr SvgStroke kContourStroke{kSvgVermillion, 2.0};
constexpr SvgStroke kTurnStroke{kSvgVermillion, 1.0, "3 4"};

class PathPicture {
 public:
  PathPicture(const std::vector<ExplorationRun>& runs, const ActuationModel& actuation,
              double tolerance)
      : runs_(runs),
        actuation_(actuation),
        tolerance_(tolerance),
        view_(view_of(runs)),
        unit_(display_unit(kPathHeight / view_.px_per_m, "m")),
        svg_(width_px(), kHeight, kFontPx) {}

  std::string document(const std::string& scene_name) {
    svg_.text({0.5 * width_px(), kTitleLine}, shortened(scene_name, width_px()),
              {"middle", kTitlePx});
    for (std::size_t i = 0; i < runs_.size(); ++i) {
      draw_path(i);
      draw_angle(i);
    }
    return svg_.document();
  }

 private:
  int width_px() const { return kRunWidth * static_cast<int>(runs_.size()); }

  // These curves, moved to `origin`, with y upwards.
  void draw(const std::vector<Curve>& curves, const SvgPoint& origin, const SvgStroke& stroke) {
    std::vector<SvgLine> lines;
    for (const Curve& curve : curves) {
      SvgLine line = simplified_line(curve, tolerance_);
      for (SvgPoint& p : line) p = {origin.x() + p.x(), origin.y() - p.y()};
      lines.push_back(std::move(line));
    }
    svg_.lines(lines, stroke);
  }

  void draw_key(const SvgBox& area, int top, const std::vector<KeyLine>& lines) {
    double y = top;
    for (const KeyLine& entry : lines) {
      const double left = area.middle().x() - kKeyLeft;
      svg_.line({{left, y}, {left + kKeySample, y}}, entry.stroke);
      svg_.text({left + kKeySample + kKeyGap, y + kKeyDrop}, entry.words);
      y += kKeyLine;
    }
  }

  // A2 to the left and A1 upwards, with the middle of the view in the middle of the area.
  void draw_path(std::size_t i) {
    const ExplorationRun& run = runs_[i];
    const SvgBox area = panel_area(i, kPathTop, kPathHeight);
    const double px_per_shown = view_.px_per_m / unit_.factor;
    const PicturePoint middle = unit_.factor * view_.middle_m;
    const PicturePoint half = 0.5 / px_per_shown * PicturePoint(kPanelWidth, kPathHeight);
    SvgAxes axes{area, round_ticks(middle.x() - half.x(), middle.x() + half.x()),
                 round_ticks(middle.y() - half.y(), middle.y() + half.y()),
                 with_unit("A2", unit_.name), with_unit("A1", unit_.name)};
    for (SvgTick& tick : axes.across) {
      tick.at = area.middle().x() - px_per_shown * (tick.at - middle.x());
    }
    for (SvgTick& tick : axes.up) {
      tick.at = area.middle().y() - px_per_shown * (tick.at - middle.y());
    }
    svg_.axes(axes);
    svg_.text({area.middle().x(), area.top - kHeadGap}, run.a4 ? "with A4" : "without A4",
              {"middle"});
    const auto shown = [this](const PicturePoint& at_m) {
      const PicturePoint px = view_.px_per_m * (at_m - view_.middle_m);
      return PicturePoint(-px.x(), px.y());
    };
    Curve path, followed;
    for (const TickRecord& r : run.records) path.push_back(shown({r.device_m[1], r.device_m[0]}));
    for (const PicturePoint& p : followed_m(run)) followed.push_back(shown(p));
    draw({followed}, area.middle(), kContourStroke);
    draw({path}, area.middle(), kPathStroke);
    const bool is_walk = run.contour_scene_m.empty();
    draw_key(area, kPathKeyTop,
             {{is_walk ? "path to follow, at the start" : "contour at the start", kContourStroke},
              {"path of the device", kPathStroke}});
  }

  void draw_angle(std::size_t i) {
    const ExplorationRun& run = runs_[i];
    const SvgBox area = panel_area(i, kAngleTop, kAngleHeight);
    const double end_s = run.records.back().time_s > 0.0 ? run.records.back().time_s : 1.0;
    const auto y_of_deg = [&](double angle_deg) {
      return area.bottom - AngleCurve::kPxPerDeg * (angle_deg - kLeastAngle_deg);
    };
    SvgAxes axes{area, round_ticks(0.0, end_s), {}, "time (s)", "contact angle (deg)"};
    for (SvgTick& tick : axes.across) tick.at = area.left + kPanelWidth / end_s * tick.at;
    for (const int angle_deg : {0, 30, 60, 90}) {
      axes.up.push_back({y_of_deg(angle_deg), std::to_string(angle_deg)});
    }
    svg_.axes(axes);
    svg_.line({{area.left, y_of_deg(kTurnFrom_deg)}, {area.right, y_of_deg(kTurnFrom_deg)}},
              kTurnStroke);
    draw(AngleCurve(run).stretches(), {area.left, y_of_deg(0.0)}, kPathStroke);
    draw_key(area, kAngleKeyTop, {{angle_name(actuation_), kPathStroke}, {"30 deg", kTurnStroke}});
  }

  const std::vector<ExplorationRun>& runs_;
  const ActuationModel& actuation_;
  double tolerance_;
  View view_;
  DisplayUnit unit_;
  SvgPicture svg_;
};

// The picture with the smallest tolerance at which it is small enough.
std::string path_svg(const std::vector<ExplorationRun>& runs, const ActuationModel& actuation,
                     const std::string& scene_name) {
  for (double tolerance = kTolerance;; tolerance *= 2.0) {
    std::string svg = PathPicture(runs, actuation, tolerance).document(scene_name);
    if (svg.size() <= kLargestPicture || tolerance > kLargestTolerance) return svg;
  }
}

}  // namespace

Result<std::string> write_path_picture(const std::vector<ExplorationRun>& runs,
                                       const ActuationModel& actuation,
                                       const std::string& scene_name, const std::string& svg_path) {
  return write_text_file(svg_path, path_svg(runs, actuation, scene_name));
}

}  // namespace palpate
