#include "engine/cli/page_stiffness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "geometry/base/printable.h"

namespace palpate {
namespace {

// Of the names of PageSettings: "material/wood/stiffness".
constexpr std::string_view kMaterial = "material/";
// What couplings_of() reads of a material.
constexpr std::array<std::string_view, 3> kWallKeys = {"stiffness", "damping", "textureHeight"};

// The settings of the page that a wall's stiffness depends on.
struct WallSettings {
  CouplingSettings loop;
  std::vector<MaterialChange> materials;

  // Whether a wall depends on a setting of this name.
  bool set(const std::string& name, double value) {
    if (name == "stiffness") {
      loop.stiffness_N_per_m = value;
    } else if (name == "damping") {
      loop.damping_Ns_per_m = value;
    } else {
      return set_material(name, value);
    }
    return true;
  }

 private:
  bool set_material(const std::string& name, double value) {
    const std::size_t slash = name.rfind('/');
    if (!name.starts_with(kMaterial) || slash < kMaterial.size()) return false;
    const std::string material = name.substr(kMaterial.size(), slash - kMaterial.size());
    const std::string key = name.substr(slash + 1);
    if (std::find(kWallKeys.begin(), kWallKeys.end(), key) == kWallKeys.end()) return false;
    for (MaterialChange& change : materials) {
      if (change.material != material || change.key != key) continue;
      change.value = value;
      return true;
    }
    materials.push_back({material, key, value});
    return true;
  }
};

class PageStiffness final : public WallJudge {
 public:
  PageStiffness(const DeviceDescription& device, const PreparedRun& prepared,
                const RunStiffness& chosen)
      : scene_(prepared.scene),
        loop_{device, chosen.zones.period_s, chosen.peak_force_N},
        allowed_(chosen.allowed),
        kept_{prepared.setup.haptics.coupling, {}},
        kept_zone_(chosen.worst.zone()) {
    couplings_of(scene_, kept_.loop, {}, &known_);  // so that no message of the page waits for it
  }

  Result<std::string> judge(const std::string& name, double value) override {
    judged_ = kept_;
    judged_zone_ = kept_zone_;
    // The page refuses what is no value of a setting.
    if (!std::isfinite(value) || value < 0.0 || !judged_.set(name, value)) return std::string();
    const auto worst =
        worst_surface(couplings_of(scene_, judged_.loop, judged_.materials, &known_), loop_);
    if (!worst) return worst.error();
    judged_zone_ = worst->judged.zone();
    if (judged_zone_ == StiffnessZone::kRefused && allowed_.empty()) return refused(name, *worst);
    return judged_zone_ == kept_zone_ ? std::string() : told(worst->judged);
  }

  void keep() override {
    kept_ = std::move(judged_);
    kept_zone_ = judged_zone_;
  }

 private:
  static Error refused(const std::string& name, const WorstSurface& worst) {
    const bool is_own =
        name == (worst.is_of_loop ? std::string("stiffness")
                                  : std::string(kMaterial) + worst.judged.surface + "/stiffness");
    if (is_own) return invalid_argument(name, too_stiff_text(worst));
    return invalid_argument(name, "is refused: the stiffness of \"" +
                                      printable(worst.judged.surface) + "\" then " +
                                      too_stiff_text(worst));
  }

  std::string told(const JudgedStiffness& worst) const {
    std::ostringstream text;
    text << "stiffness " << worst.stiffness_N_per_m << " N/m of \"" << printable(worst.surface)
         << "\": " << zone_text(worst.zone(), allowed_);
    return text.str();
  }

  const Scene& scene_;
  MapCurvatures known_;
  JudgedLoop loop_;
  std::string allowed_;
  WallSettings kept_, judged_;
  StiffnessZone kept_zone_, judged_zone_ = StiffnessZone::kStable;
};

}  // namespace

std::unique_ptr<WallJudge> make_wall_judge(const DeviceDescription& device,
                                           const PreparedRun& prepared,
                                           const RunStiffness& chosen) {
  return std::make_unique<PageStiffness>(device, prepared, chosen);
}

}  // namespace palpate
