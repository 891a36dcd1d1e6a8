#pragma once

// The stiffness of the surfaces of a scene, and whether walls of this stiffness are passive and
// stable on a device.

#include <string>
#include <vector>

#include "engine/devices/stability_limits.h"
#include "engine/scene/scene.h"
#include "geometry/base/result.h"
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

// The coupling of the loop first, then that of each material that declares a stiffness, a damping
// or a texture. The full relief is considered, because no texel is faded out for a hand that does
// not move. Force shading is not considered.
std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop);

// The verdict on a coupling that is used with a device.
struct CouplingVerdict {
  SurfaceCoupling surface;
  double effective_N_per_m =
      0.0;  // SurfaceCoupling::effective_stiffness_N_per_m(), which is compared with the limits
  StabilityLimits limits;
  bool is_passive = false;
  bool is_stable = false;
};

// The verdicts for a hand at this depth, in metres. Returns the errors of stability_limits().
Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceDescription& device,
                                                     const ServoTiming& timing, double depth_m);

}  // namespace palpate
