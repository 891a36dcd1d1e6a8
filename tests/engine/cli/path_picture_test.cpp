// The picture of `run`: its ticks, legend, title, size and accuracy, and its errors.

#include "engine/cli/path_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "engine/cli/simplified_line.h"
#include "haptics/record_vectors.h"
#include "tests/engine/cli/run_program.h"
#include "tests/helpers/needs.h"

namespace palpate {
namespace {

using test::content_of;
using test::TemporaryFolder;

constexpr double kTwoPi = 2.0 * std::numbers::pi;

// A closed contour of radius `size_m` / 2 with `waves` bulges of a tenth of the radius.
std::vector<Vec3> wavy_contour(double size_m, int waves, int points) {
  std::vector<Vec3> contour;
  for (int i = 0; i <= points; ++i) {
    const double angle = kTwoPi * i / points;
    const double radius_m = 0.5 * size_m * (0.9 + 0.1 * std::cos(waves * angle));
    contour.emplace_back(radius_m * std::cos(angle), radius_m * std::sin(angle), 0.0);
  }
  return contour;
}

// A run of 28 s at 1 kHz along the contour; `position_m` is the scene's place in the device frame.
ExplorationRun run_along(const std::vector<Vec3>& contour, bool a4,
                         const Vec3& position_m = Vec3::Zero()) {
  ExplorationRun run;
  run.a4 = a4;
  run.contour_scene_m = contour;
  constexpr std::size_t kTicks = 28'000;
  for (std::size_t i = 0; i < kTicks; ++i) {
    TickRecord record;
    record.tick = i;
    record.time_s = 1e-3 * static_cast<double>(i);
    put(position_m + contour[i * (contour.size() - 1) / kTicks], record.device_m);
    put(ScenePose{Quat::Identity(), position_m}, record.q_before_wxyz, record.o_before_m);
    record.contact = i > 1000;
    record.alpha_rad = 0.25 * std::numbers::pi * (1.0 + std::sin(1e-3 * static_cast<double>(i)));
    run.records.push_back(record);
  }
  return run;
}

ActuationModel actuated(int sensors, const std::vector<Vec3>& axes) {
  return ActuationModel::from_axes(sensors, axes).value();
}

std::string drawn(const std::vector<ExplorationRun>& runs,
                  const ActuationModel& actuation = actuated(2, {Vec3::UnitX()}),
                  const std::string& name = "star.glb") {
  const TemporaryFolder folder;
  const auto written = write_path_picture(runs, actuation, name, folder.path("paths.svg"));
  EXPECT_TRUE(written) << written.error().to_string();
  return content_of(folder.path("paths.svg"));
}

std::vector<std::string> texts_of(const std::string& svg) {
  std::vector<std::string> texts;
  const std::regex text("<text[^>]*>([^<]*)");
  for (std::sregex_iterator i(svg.begin(), svg.end(), text), end; i != end; ++i) {
    texts.push_back((*i)[1]);
  }
  return texts;
}

std::size_t count_of(const std::vector<std::string>& texts, const std::string& text) {
  return static_cast<std::size_t>(std::count(texts.begin(), texts.end(), text));
}

// The polylines of this colour, pixels.
std::vector<std::vector<PicturePoint>> lines_of_colour(const std::string& svg,
                                                       const std::string& colour) {
  std::vector<std::vector<PicturePoint>> lines;
  for (std::size_t at = svg.find("<path"); at != std::string::npos;
       at = svg.find("<path", at + 1)) {
    const std::string element = svg.substr(at, svg.find('>', at) - at);
    if (element.find(colour) == std::string::npos) continue;
    for (std::size_t i = element.find(" d=\"") + 4; i < element.size(); ++i) {
      if (element[i] != 'M' && element[i] != 'L') continue;
      char* end = nullptr;
      const double x = std::strtod(element.c_str() + i + 1, &end);
      const double y = std::strtod(end + 1, nullptr);
      if (element[i] == 'M') lines.emplace_back();
      lines.back().emplace_back(x, y);
    }
  }
  return lines;
}

// The contour of the first run, pixels. Legend samples, the second run and the line at 30 deg have
// its colour; they lie elsewhere.
std::vector<PicturePoint> first_contour(const std::string& svg) {
  std::vector<PicturePoint> line;
  for (const auto& part : lines_of_colour(svg, "#D55E00")) {
    if (part.front().x() > 480.0 || part.front().y() > 410.0) continue;
    line.insert(line.end(), part.begin(), part.end());
  }
  return line;
}

double distance_to_segment(const PicturePoint& p, const PicturePoint& a, const PicturePoint& b) {
  const PicturePoint along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).norm();
}

double distance_to_line(const PicturePoint& p, const std::vector<PicturePoint>& line) {
  double least = (p - line.front()).norm();
  for (std::size_t i = 1; i < line.size(); ++i) {
    least = std::min(least, distance_to_segment(p, line[i - 1], line[i]));
  }
  return least;
}

double farthest(const std::vector<PicturePoint>& points, const std::vector<PicturePoint>& line) {
  double most = 0.0;
  for (const PicturePoint& p : points) most = std::max(most, distance_to_line(p, line));
  return most;
}

// ---- ticks, legend and title -------------------------------------------------------------------

TEST(PathPicture, HasTicksInAUnitThatSuitsTheSceneSize) {
  const struct {
    double size_m;
    const char* axis;
    std::vector<std::string> ticks;
  } cases[] = {{1e-3, "A2 (mm)", {"-0.4", "-0.2", "0.0", "0.2", "0.4"}},
               {0.2, "A2 (mm)", {"-100", "-50", "0", "50", "100"}},
               {10.0, "A2 (m)", {"-4", "-2", "0", "2", "4"}}};
  for (const auto& c : cases) {
    const auto contour = wavy_contour(c.size_m, 5, 1000);
    const auto texts = texts_of(drawn({run_along(contour, false), run_along(contour, true)}));
    EXPECT_EQ(count_of(texts, c.axis), 2u) << c.size_m;
    for (const std::string& tick : c.ticks) {
      EXPECT_GE(count_of(texts, tick), 2u) << tick << " of a scene of " << c.size_m << " m";
    }
  }
}

TEST(PathPicture, ShowsAScenePlacedFarFromTheOriginAtItsOwnSize) {
  const auto contour = wavy_contour(1e-3, 5, 1000);
  const std::string svg = drawn({run_along(contour, false, {2.0, 1.0, 0.0})});
  const auto texts = texts_of(svg);
  EXPECT_EQ(count_of(texts, "1000.0"), 1u) << "the middle along A2, mm";
  EXPECT_EQ(count_of(texts, "2000.0"), 1u) << "the middle along A1, mm";
  EXPECT_GT(first_contour(svg).size(), 50u) << "a point instead of a curve";
}

TEST(PathPicture, NamesTheActuatedAxisInUse) {
  const auto contour = wavy_contour(0.2, 5, 1000);
  const std::vector<ExplorationRun> runs{run_along(contour, false)};
  const struct {
    ActuationModel actuation;
    const char* name;
  } cases[] = {
      {actuated(2, {{1, 0, 0}}), "contact normal to A1"},
      {actuated(2, {{0, 3, 0}}), "contact normal to A2"},
      {actuated(3, {{0, 0, -1}}), "contact normal to A3"},
      {actuated(2, {{0.6, 0.8, 0}}), "contact normal to (0.6, 0.8, 0)"},
      {actuated(3, {{0, 1, 0}, {0, 0, 2}}), "contact normal to the plane of A2 and A3"},
      {actuated(3, {{0, 0, 1}, {0, 1, 0}}), "contact normal to the plane of A2 and A3"},
      {actuated(3, {{0, 0, 1}, {0.6, 0.8, 0}}),
       "contact normal to the plane across (-0.8, 0.6, 0)"},
      {actuated(2, {{1, 0, 0}, {0, 1, 0}}), "contact angle (every sensed axis is actuated)"},
      {ActuationModel::from_counts(2, 0).value(), "contact angle (no axis is actuated)"}};
  for (const auto& c : cases) {
    EXPECT_EQ(count_of(texts_of(drawn(runs, c.actuation)), c.name), 1u) << c.name;
  }
}

TEST(PathPicture, HasTheSceneNameAsItsTitleWhateverItsCharacters) {
  const auto contour = wavy_contour(0.2, 5, 100);
  const std::vector<ExplorationRun> runs{run_along(contour, false)};
  const auto title = [&](const std::string& name) {
    return texts_of(drawn(runs, actuated(2, {Vec3::UnitX()}), name));
  };
  EXPECT_EQ(count_of(title("star.glb"), "star.glb"), 1u);
  EXPECT_EQ(count_of(title("a_b <i>&amp;'\"`id`.glb"), "a_b &lt;i&gt;&amp;amp;'\"`id`.glb"), 1u);
  EXPECT_EQ(count_of(title("größe.glb"), "größe.glb"), 1u);
  std::string cut;
  for (int i = 0; i < 300; ++i) cut += "ö";
  for (const std::string& text : title(cut))
    EXPECT_LT(text.size(), 150u) << "wider than the picture";
}

TEST(PathPicture, DrawsTheFollowedPathOfAWalk) {
  ExplorationRun run = run_along(wavy_contour(0.2, 5, 1000), false);
  run.places_scene_m.swap(run.contour_scene_m);
  const auto texts = texts_of(drawn({run}));
  EXPECT_EQ(count_of(texts, "path to follow, at the start"), 1u);
  EXPECT_EQ(count_of(texts, "contour at the start"), 0u);
}

TEST(PathPicture, DrawsARunWithoutContactAndARunOfOneTick) {
  ExplorationRun still = run_along(wavy_contour(0.2, 5, 1000), false);
  for (TickRecord& record : still.records) record.contact = 0;
  const auto expect_whole = [](const std::string& svg) {
    EXPECT_GT(svg.size(), 4000u);
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_EQ(count_of(texts_of(svg), "contact angle (deg)"), 1u);
  };
  expect_whole(drawn({still}));
  still.records.resize(1);
  still.contour_scene_m.clear();
  expect_whole(drawn({still}));
}

// ---- size and accuracy -------------------------------------------------------------------------

TEST(PathPicture, DrawsAMillionPointsInASmallFileWithinTheTolerance) {
  // A million points on 60 bulges, whose curves are smooth at the resolution of the picture.
  const auto contour = wavy_contour(0.3, 60, 1'000'000);
  const std::string svg = drawn({run_along(contour, false), run_along(contour, true)});
  EXPECT_LE(svg.size(), kLargestPicture);
  const std::vector<PicturePoint> line = first_contour(svg);
  ASSERT_GT(line.size(), 200u);
  // The scale follows from the picture's extent: A2 to the left, A1 upwards. Both ends of the
  // extent may be off by the tolerance, so the scale adds as much.
  double left = 1e9, right = 0.0, top = 1e9, bottom = 0.0;
  for (const PicturePoint& p : line) {
    left = std::min(left, p.x());
    right = std::max(right, p.x());
    top = std::min(top, p.y());
    bottom = std::max(bottom, p.y());
  }
  double most_x = 0.0, most_y = 0.0;
  for (const Vec3& p : contour) {
    most_x = std::max(most_x, std::abs(p.x()));
    most_y = std::max(most_y, std::abs(p.y()));
  }
  const double px_per_m = 0.25 * ((right - left) / most_y + (bottom - top) / most_x);
  std::vector<PicturePoint> expected;
  for (std::size_t i = 0; i < contour.size(); i += 100) {
    expected.emplace_back(0.5 * (left + right) - px_per_m * contour[i].y(),
                          0.5 * (top + bottom) - px_per_m * contour[i].x());
  }
  EXPECT_LT(farthest(expected, line), 2.0 * 0.4 + 0.05);
  EXPECT_LT(farthest(line, expected), 2.0 * 0.4 + 0.05);
}

TEST(PathPicture, StaysWithinItsSizeForACurveThatFillsThePanel) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
  std::vector<Vec3> noise;
  for (int i = 0; i < 200'000; ++i) noise.emplace_back(coordinate(random), coordinate(random), 0.0);
  ExplorationRun run = run_along(noise, false);
  for (TickRecord& record : run.records) {
    record.contact = record.tick % 3 != 0;
    record.alpha_rad = record.tick % 2 == 0 ? 0.1 : 1.5;
  }
  EXPECT_LE(drawn({run, run}).size(), kLargestPicture);
}

TEST(SimplifiedLine, DeviatesByTheToleranceAtMost) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 60; ++trial) {
    const double step = std::pow(10.0, -2.0 + 0.05 * trial);
    std::vector<PicturePoint> line{PicturePoint::Zero()};
    double heading = 0.0;
    for (int i = 0; i < 2000; ++i) {
      heading += (trial % 3) * 0.2 * normal(random);  // straight, winding, and a tangle
      line.push_back(line.back() + step * PicturePoint(std::cos(heading), std::sin(heading)) +
                     (trial % 2) * 0.3 * PicturePoint(normal(random), normal(random)));
    }
    const auto simple = simplified_line(line, 0.4);
    EXPECT_EQ(simple.front(), line.front());
    EXPECT_EQ(simple.back(), line.back());
    EXPECT_LE(farthest(line, simple), 0.4 * (1.0 + 1e-12)) << "trial " << trial;
  }
}

TEST(SimplifiedLine, KeepsTheCornersOfStraightLinesAndNothingElse) {
  std::vector<PicturePoint> line;
  for (int i = 0; i <= 1000; ++i) line.emplace_back(0.1 * i, 0.0);
  for (int i = 1; i <= 1000; ++i) line.emplace_back(100.0, 0.1 * i);
  EXPECT_LE(simplified_line(line, 0.4).size(), 5u);
  EXPECT_LE(simplified_line(std::vector<PicturePoint>(1000, PicturePoint(1.0, 2.0)), 0.4).size(),
            2u);
  EXPECT_TRUE(simplified_line({}, 0.4).empty());
}

TEST(SimplifiedLine, KeepsTheTurningPointsOfALineThatGoesBack) {
  std::vector<PicturePoint> line;
  for (int i = 0; i <= 1000; ++i) line.emplace_back(0.1 * i, 0.0);
  for (int i = 999; i >= -500; --i) line.emplace_back(0.1 * i, 0.0);
  for (int i = -499; i <= 0; ++i) line.emplace_back(0.1 * i, 0.0);
  const auto simple = simplified_line(line, 0.4);
  EXPECT_LE(farthest({{100.0, 0.0}, {-50.0, 0.0}}, simple), 0.4);
  EXPECT_LE(simple.size(), 8u);
}

// ---- errors ------------------------------------------------------------------------------------

TEST(PathPicture, NamesTheFileThatAFullDiskDoesNotTake) {
  PALPATE_NEEDS(test::lack_of_full_disk());
  const std::vector<ExplorationRun> runs{run_along(wavy_contour(0.2, 5, 1000), false)};
  const auto full = write_path_picture(runs, actuated(2, {Vec3::UnitX()}), "star", "/dev/full");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kFileUnwritable);
  EXPECT_EQ(full.error().path, "/dev/full");
}

TEST(PathPicture, NeedsNoOtherProgram) {
  const std::vector<ExplorationRun> runs{run_along(wavy_contour(0.2, 5, 1000), false)};
  const std::string with_programs = drawn(runs);
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  const std::string alone = drawn(runs);
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_EQ(alone, with_programs) << "the same bytes";
}

}  // namespace
}  // namespace palpate
