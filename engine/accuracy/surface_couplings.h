#pragma once

// The stiffness of the surfaces of a scene, and whether walls of this stiffness are passive and
// stable on a device.

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/devices/stability_limits.h"
#include "engine/devices/stiffness_zones.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"
#include "geometry/mesh/height_map.h"
#include "haptics/effects/virtual_coupling.h"

namespace palpate {

struct SurfaceCoupling {
  std::string name;  // of the material, or "surfaces without their own"
  CouplingSettings coupling;
  // Largest curvature of the relief along the axes of the image, 1/m; 0 without a texture. A relief
  // h(x) pressed to the depth d acts along the surface like a spring of stiffness K d h'', in
  // addition to K. For a wave of amplitude a and length L, the curvature is a (2 pi / L)^2.
  double relief_per_m = 0.0;

  // The largest stiffness rendered at this depth.
  double effective_stiffness_N_per_m(double depth_m) const {
    return coupling.stiffness_N_per_m * (1.0 + depth_m * relief_per_m);
  }
};

// A parameter of a material that is no longer as the file states it, in the unit of the file.
struct MaterialChange {
  std::string material, key;
  double value = 0.0;
};

// The largest curvature of a height map along its rows and along its columns, per texel squared.
// It takes a second for four million texels.
using MapCurvatures = std::map<const HeightMap*, std::array<double, 2>>;

// The coupling of the loop first, then that of each material that declares a stiffness, a damping
// or a texture. The full relief is considered, because no texel is faded out for a hand that does
// not move. Force shading is not considered. known: keeps the curvatures from one call to the next.
std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop,
                                          std::span<const MaterialChange> changes = {},
                                          MapCurvatures* known = nullptr);

// The verdict on a coupling that is used with a device.
struct CouplingVerdict {
  SurfaceCoupling surface;
  double effective_N_per_m =
      0.0;  // SurfaceCoupling::effective_stiffness_N_per_m(), which is compared with the limits
  StabilityLimits limits;
  bool is_passive = false;
  bool is_stable = false;
  StiffnessZones zones = {};  // if the device moves motors
  StiffnessZone zone() const { return zones.zone_of(effective_N_per_m); }
};

// The verdicts for a hand at this depth, in metres. Returns the errors of stability_limits().
Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceDescription& device,
                                                     const ServoTiming& timing, double depth_m);

}  // namespace palpate
