#pragma once

// How stiff the surfaces of a scene are, and whether a device keeps that.

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
  // Largest curvature of its relief along the axes of the image, 1/m; 0 without a texture. A relief
  // h (x) pressed to the depth d pushes along the surface as a spring of K d h'' does, beside the K
  // of its own: a wave of amplitude a and length L has a (2 pi / L)^2.
  double relief_per_m = 0.0;

  // The stiffest that is felt at this depth.
  double effective_stiffness_N_per_m(double depth_m) const {
    return coupling.stiffness_N_per_m * (1.0 + depth_m * relief_per_m);
  }
};

// Those of the loop first, then of each material that declares a stiffness, a damping or a texture.
// A relief is that of a hand at rest, whom no texel is too fine for. Force shading is left out.
std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop);

// A coupling on a device.
struct CouplingVerdict {
  SurfaceCoupling surface;
  double effective_N_per_m =
      0.0;  // SurfaceCoupling::effective_stiffness_N_per_m(), which the limits are for
  StabilityLimits limits;
  bool is_passive = false;
  bool is_stable = false;
};

// At this depth. An error as of stability_limits().
Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceDescription& device,
                                                     const ServoTiming& timing, double depth_m);

}  // namespace palpate
