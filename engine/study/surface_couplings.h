#pragma once

// How stiff the surfaces of a scene are, and whether a device keeps that.

#include <string>
#include <vector>

#include "engine/scene.h"
#include "engine/stability_limits.h"
#include "geometry/result.h"
#include "haptics/virtual_coupling.h"

namespace palpate {

struct SurfaceCoupling {
  std::string name;  // of the material, or "surfaces without their own"
  CouplingSettings coupling;
};

// Those of the loop first, then of each material that declares a stiffness or a damping.
std::vector<SurfaceCoupling> couplings_of(const Scene& scene, const CouplingSettings& loop);

// A coupling on a device.
struct CouplingVerdict {
  SurfaceCoupling surface;
  StabilityLimits limits;
  bool is_passive = false;
  bool is_stable = false;
};

// An error as of stability_limits().
Result<std::vector<CouplingVerdict>> judge_couplings(const std::vector<SurfaceCoupling>& couplings,
                                                     const DeviceMechanics& device,
                                                     const ServoTiming& timing);

}  // namespace palpate
