#pragma once

// Reduces the number of points of a polyline within a tolerance.

#include <vector>

#include <Eigen/Core>

namespace palpate {

using PicturePoint = Eigen::Vector2d;

// Returns some of the points, in the same order, always including the first and the last point. No
// point of the given line is farther than `tolerance` from the returned line. The tolerance has the
// unit of the points. Requires finite points. Linear time.
std::vector<PicturePoint> simplified_line(const std::vector<PicturePoint>& line, double tolerance);

}  // namespace palpate
