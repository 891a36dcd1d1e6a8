#pragma once

// Simplifies a polyline within a tolerance.

#include <vector>

#include <Eigen/Core>

namespace palpate {

using PicturePoint = Eigen::Vector2d;

// Some of the points, in order, with the first and the last one: no point of the given line is
// farther than `tolerance` from the returned line. Linear time. Expects finite points.
std::vector<PicturePoint> simplified_line(const std::vector<PicturePoint>& line, double tolerance);

}  // namespace palpate
