#pragma once

// A device path that explores the surface of a body.

#include <cstddef>
#include <cstdint>

#include "benchmarks/scanned_body.h"
#include "engine/accuracy/sphere_paths.h"

namespace palpate::bench {

// The way in which the hand touches the surface.
struct WalkStyle {
  double proxy_radius_m = 0.0;
  HeightSwing swing;  // height of the device over the centre of a proxy in contact
  std::uint64_t seed = 1;
};

// A random walk over the surface of the body, with steps of kSpherePathStep_m and a slowly changing
// heading. The device is above or below the surface, as WalkStyle::swing states. The device slows
// down at sharp edges of the body. The path begins outside. Frame of the body, metres.
// Deterministic.
DevicePath contact_walk(const ScannedBody& body, const WalkStyle& style, std::size_t samples);

}  // namespace palpate::bench
