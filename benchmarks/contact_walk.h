#pragma once

// A hand that feels its way over a body.

#include <cstddef>
#include <cstdint>

#include "benchmarks/scanned_body.h"
#include "engine/accuracy/sphere_paths.h"

namespace palpate::bench {

// How a hand feels.
struct WalkStyle {
  double proxy_radius_m = 0.0;
  HeightSwing swing;  // of the device, over where the proxy's centre touches
  std::uint64_t seed = 1;
};

// A random walk over the surface of the body, kSpherePathStep_m a sample, which turns as it goes,
// with the device above or below it. Where the surface turns sharply, at an edge of the body, the
// device takes its time. Comes from outside. The body's frame, metres. The same each time.
DevicePath contact_walk(const ScannedBody& body, const WalkStyle& style, std::size_t samples);

}  // namespace palpate::bench
