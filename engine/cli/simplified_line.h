#pragma once

// Reduces the number of points of a polyline within a tolerance.

#include <vector>

#include <Eigen/Core>

namespace palpate {

using PicturePoint = Eigen::Vector2d;

// Returns a part of the points, in the same order; the first and the last point are always kept. No
// point of the given line is farther than `tolerance` from the returned line. The tolerance has the
// unit of the points. Requires finite points. Linear time.
std::vector<PicturePoint> simplified_line(const std::vector<PicturePoint>& line, double tolerance);

}  // namespace palpate
