#include "tests/helpers/friction_judge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/QR>

namespace palpate::test {
namespace {

Vec3 nearest_on_edge(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double part = std::clamp((p - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return a + part * along;
}

struct Contact {
  std::size_t face;
  Vec3 nearest;  // the point of the face
  Vec3 normal;
};

// Whether no corner of a triangle is in front of the plane of a contact by more than touch_m.
bool lies_behind(const Corners& t, const Contact& contact, double touch_m) {
  const auto height_m = [&](const Vec3& p) { return contact.normal.dot(p - contact.nearest); };
  return std::max({height_m(t.a), height_m(t.b), height_m(t.c)}) <= touch_m;
}

}  // namespace

Vec3 nearest_point(const Corners& t, const Vec3& p) {
  const Vec3 n = (t.b - t.a).cross(t.c - t.a).normalized();
  const Vec3 foot = p - n.dot(p - t.a) * n;
  const std::array<Vec3, 3> corners = {t.a, t.b, t.c};
  bool is_inside = true;
  Vec3 best = t.a;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3& from = corners[i];
    const Vec3& to = corners[(i + 1) % 3];
    if (n.dot((to - from).cross(foot - from)) < 0.0) is_inside = false;
    const Vec3 q = nearest_on_edge(from, to, p);
    if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
  }
  return is_inside ? foot : best;
}

std::vector<std::size_t> FrictionJudge::touched(std::span<const FrictionFace> faces,
                                                const Vec3& proxy) const {
  std::vector<std::size_t> found;
  const double reach_m = radius_m_ + touch_m_;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Corners& t = faces[i].corners;
    const Vec3 low = t.a.cwiseMin(t.b).cwiseMin(t.c) - Vec3::Constant(reach_m);
    const Vec3 high = t.a.cwiseMax(t.b).cwiseMax(t.c) + Vec3::Constant(reach_m);
    if ((proxy.array() < low.array()).any() || (proxy.array() > high.array()).any()) continue;
    if ((nearest_point(t, proxy) - proxy).norm() <= reach_m) found.push_back(i);
  }
  return found;
}

std::vector<BorneForce> FrictionJudge::borne(std::span<const FrictionFace> faces, const Vec3& proxy,
                                             const Vec3& force_N,
                                             const std::optional<Vec3>& motion_plane_normal) const {
  std::vector<Contact> contacts;
  for (const std::size_t i : touched(faces, proxy)) {
    const Corners& t = faces[i].corners;
    const Vec3 nearest = nearest_point(t, proxy);
    Vec3 normal = (t.b - t.a).cross(t.c - t.a).normalized();
    if (radius_m_ > 0.0) {
      normal = (proxy - nearest).normalized();
    } else if (normal.dot(proxy - t.a) < 0.0) {
      normal = -normal;
    }
    if (motion_plane_normal) {
      normal -= normal.dot(*motion_plane_normal) * *motion_plane_normal;
      if (normal.norm() < 1e-6) continue;  // the face cannot press within the plane of motion
      normal.normalize();
    }
    contacts.push_back({i, nearest, normal});
  }
  std::vector<BorneForce> ways;
  const double rounding_N = 1e-9 * force_N.norm();
  // Within touch_m of a face and of its edge, the direction to a sphere is uncertain by this angle.
  const double turn_rad = radius_m_ > 0.0 ? std::sqrt(2.0 * touch_m_ / radius_m_) : 0.0;
  const auto consider = [&](std::span<const std::size_t> chosen) {
    const std::size_t count = chosen.size();
    const auto normal = [&](std::size_t i) -> const Vec3& { return contacts[chosen[i]].normal; };
    using Columns = Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 3>;
    Columns columns(3, count);
    for (std::size_t i = 0; i < count; ++i) columns.col(static_cast<Eigen::Index>(i)) = normal(i);
    // Normals that nearly coincide leave no digits in the products of columns; a QR keeps them.
    const Eigen::ColPivHouseholderQR<Columns> qr(columns);
    if (std::abs(qr.matrixR().diagonal().head(static_cast<Eigen::Index>(count)).prod()) < 1e-6) {
      return;
    }
    const Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 3, 1> parts = qr.solve(force_N);
    if ((parts.array() < -rounding_N).any()) return;
    BorneForce way;
    const Vec3 along_normals = columns * parts;
    const Vec3 tangential = force_N - along_normals;
    way.normal_N = along_normals.norm();
    way.tangential_N = tangential.norm();
    for (std::size_t i = 0; i < count; ++i) {
      const FrictionCone& cone = faces[contacts[chosen[i]].face].cone;
      const double share = parts[static_cast<Eigen::Index>(i)] / way.normal_N;
      way.mu_s += share * cone.static_friction;
      way.mu_k += share * cone.dynamic_friction;
      way.normals.push_back(normal(i));
    }
    for (std::size_t j = 0; j < contacts.size(); ++j) {
      if (std::find(chosen.begin(), chosen.end(), j) != chosen.end()) continue;
      const double approach_N = tangential.dot(contacts[j].normal);
      if (approach_N <= rounding_N + turn_rad * way.tangential_N) continue;
      bool is_behind = false;
      for (std::size_t i = 0; i < count; ++i) {
        is_behind = is_behind ||
                    lies_behind(faces[contacts[j].face].corners, contacts[chosen[i]], touch_m_);
      }
      if (!is_behind) way.slides_freely = false;
    }
    ways.push_back(way);
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    consider(std::array{i});
    for (std::size_t j = 0; j < i; ++j) {
      consider(std::array{i, j});
      if (motion_plane_normal) continue;
      for (std::size_t k = 0; k < j; ++k) consider(std::array{i, j, k});
    }
  }
  return ways;
}

}  // namespace palpate::test
