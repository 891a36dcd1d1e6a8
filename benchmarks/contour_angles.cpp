#include "benchmarks/contour_angles.h"

#include <array>
#include <cstdio>
#include <string_view>

#include "engine/scene/scene.h"
#include "models/paper_objects.h"

namespace palpate::bench {
namespace {

constexpr double kDurations_s[] = {20.0, 27.0};
constexpr double kStarts_deg[] = {0.0, 45.0};
constexpr Alignment kRules[] = {Alignment::kNearest, Alignment::kForward};

std::string_view name_of(Alignment align) {
  return align == Alignment::kNearest ? "nearest" : "forward";
}

}  // namespace

Result<std::vector<ContourCase>> measure_contour_angles(const std::string& models_dir) {
  std::vector<ContourCase> cases;
  for (const PaperObject& object : paper_objects()) {
    const std::string path = models_dir + "/" + object.name + ".glb";
    const auto scene = Scene::load(path);
    if (!scene) return scene.error();
    for (const double duration_s : kDurations_s) {
      for (const double start_deg : kStarts_deg) {
        for (const Alignment align : kRules) {
          const ContourRound round{duration_s, start_deg, align};
          const auto angle = angle_round(*scene, object.contour_m, round);
          if (!angle) return angle.error();
          cases.push_back({object.name, round, *angle});
        }
      }
    }
  }
  return cases;
}

std::string contour_angles_csv(const std::vector<ContourCase>& cases) {
  std::string csv =
      "object,start_orientation_deg,align,duration_s,mean_contact_angle_deg,contact_share\n";
  for (const ContourCase& c : cases) {
    std::array<char, 64> numbers;
    csv += c.object;
    std::snprintf(numbers.data(), numbers.size(), ",%g,", c.round.start_orientation_deg);
    csv += numbers.data();
    csv += name_of(c.round.align);
    std::snprintf(numbers.data(), numbers.size(), ",%g,%.4f,%.4f\n", c.round.duration_s,
                  c.angle.mean_deg, c.angle.contact_share);
    csv += numbers.data();
  }
  return csv;
}

}  // namespace palpate::bench
