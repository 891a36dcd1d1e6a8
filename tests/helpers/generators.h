#pragma once

// Surfaces of revolution as generators of meshes write them: the last column repeats the first, and
// a pole repeats its vertex, up to the rounding of sine and cosine. Every coordinate is stored as a
// float. Real: the type in which the generator computes.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "geometry/base/types.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

struct GeneratedMesh {
  std::string name;
  Soup soup;
};

template <typename Real>
class Generators {
 public:
  using Profile = std::vector<std::array<Real, 2>>;  // radius and height

  // The six kinds, with n columns each.
  static std::vector<GeneratedMesh> kinds(int n) {
    const int rows = std::max(2, n / 2);
    return {{"sphere", sphere(Real(0.05), n, rows)},
            {"cylinder", cylinder(Real(0.5), Real(0.7), 2, n, rows)},
            {"torus", torus(1, Real(0.4), std::max(3, rows), n)},
            {"cone", cylinder(0, 1, Real(2.3), n, rows)},
            {"capsule", capsule(1, Real(1.5), std::max(1, n / 4), n)},
            {"lathe", lathe(vase(7, Real(1.3), Real(0.3)), n, 0)}};
  }

  static Soup sphere(Real radius, int columns, int rows) {
    Soup soup;
    for (int j = 0; j <= rows; ++j) {
      const Real theta = Real(j) / Real(rows) * kPi;
      for (int i = 0; i <= columns; ++i) {
        const Real phi = Real(i) / Real(columns) * 2 * kPi;
        add(soup, -radius * std::cos(phi) * std::sin(theta), radius * std::cos(theta),
            radius * std::sin(phi) * std::sin(theta));
      }
    }
    const auto at = [&](int j, int i) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
    for (int j = 0; j < rows; ++j) {
      for (int i = 0; i < columns; ++i) {
        if (j != 0) soup.triangles.push_back({at(j, i + 1), at(j, i), at(j + 1, i + 1)});
        if (j != rows - 1) soup.triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      }
    }
    return soup;
  }

  static Soup torus(Real radius, Real tube, int rows, int columns) {
    Soup soup;
    for (int j = 0; j <= rows; ++j) {
      const Real v = Real(j) / Real(rows) * 2 * kPi;
      for (int i = 0; i <= columns; ++i) {
        const Real u = Real(i) / Real(columns) * 2 * kPi;
        add(soup, (radius + tube * std::cos(v)) * std::cos(u),
            (radius + tube * std::cos(v)) * std::sin(u), tube * std::sin(v));
      }
    }
    const auto at = [&](int j, int i) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
    for (int j = 1; j <= rows; ++j) {
      for (int i = 1; i <= columns; ++i) {
        soup.triangles.push_back({at(j, i - 1), at(j - 1, i - 1), at(j, i)});
        soup.triangles.push_back({at(j - 1, i - 1), at(j - 1, i), at(j, i)});
      }
    }
    return soup;
  }

  // With caps; a cone if a radius is 0.
  static Soup cylinder(Real top, Real bottom, Real height, int columns, int rows) {
    Soup soup;
    const Real half = height / 2;
    for (int j = 0; j <= rows; ++j) {
      const Real v = Real(j) / Real(rows);
      const Real radius = v * (bottom - top) + top;
      for (int i = 0; i <= columns; ++i) add_turned(soup, radius, -v * height + half, i, columns);
    }
    const auto at = [&](int j, int i) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
    for (int i = 0; i < columns; ++i) {
      for (int j = 0; j < rows; ++j) {
        if (top > 0 || j != 0) {
          soup.triangles.push_back({at(j, i), at(j + 1, i), at(j, i + 1)});
        }
        if (bottom > 0 || j != rows - 1) {
          soup.triangles.push_back({at(j + 1, i), at(j + 1, i + 1), at(j, i + 1)});
        }
      }
    }
    for (const bool is_top : {true, false}) {
      const Real radius = is_top ? top : bottom;
      if (radius > 0) add_cap(soup, radius, is_top ? half : -half, columns, is_top);
    }
    return soup;
  }

  static Soup capsule(Real radius, Real length, int cap_rows, int columns) {
    Profile profile;
    for (const Real from : {Real(1.5) * kPi, Real(0)}) {
      for (int i = 0; i <= cap_rows; ++i) {
        const Real angle = from + Real(i) / Real(cap_rows) * (kPi / 2);
        const Real middle = from > 0 ? -length / 2 : length / 2;
        profile.push_back({radius * std::cos(angle), middle + radius * std::sin(angle)});
      }
    }
    return lathe(profile, columns, 0);
  }

  // All triangles of all quads, also at poles, where one of two has almost no area.
  static Soup lathe(const Profile& profile, int columns, Real start) {
    Soup soup;
    const auto rows = static_cast<std::uint32_t>(profile.size());
    const Real share = 1 / Real(columns);
    for (int i = 0; i <= columns; ++i) {
      const Real phi = start + Real(i) * share * (2 * kPi);
      for (const auto& [radius, height] : profile) {
        add(soup, radius * std::sin(phi), height, radius * std::cos(phi));
      }
    }
    for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(columns); ++i) {
      for (std::uint32_t j = 0; j + 1 < rows; ++j) {
        const std::uint32_t a = j + i * rows, b = a + rows, c = b + 1, d = a + 1;
        soup.triangles.push_back({a, b, d});
        soup.triangles.push_back({c, d, b});
      }
    }
    return soup;
  }

  // A closed profile of revolution: sin(pi) instead of 0 at the upper end.
  static Profile vase(int rows, Real height, Real waist) {
    Profile profile;
    for (int j = 0; j <= rows; ++j) {
      const Real t = Real(j) / Real(rows);
      profile.push_back(
          {std::sin(t * kPi) * (Real(0.5) + waist * std::cos(5 * t)), height * (t - Real(0.3))});
    }
    return profile;
  }

 private:
  static constexpr Real kPi = static_cast<Real>(3.14159265358979323846L);

  static void add(Soup& soup, Real x, Real y, Real z) {
    soup.positions.push_back({double{static_cast<float>(x)}, double{static_cast<float>(y)},
                              double{static_cast<float>(z)}});
  }
  static void add_turned(Soup& soup, Real radius, Real y, int column, int columns) {
    const Real theta = Real(column) / Real(columns) * (2 * kPi);
    add(soup, radius * std::sin(theta), y, radius * std::cos(theta));
  }
  static void add_cap(Soup& soup, Real radius, Real y, int columns, bool is_top) {
    const auto centre = static_cast<std::uint32_t>(soup.positions.size());
    const auto count = static_cast<std::uint32_t>(columns);
    for (std::uint32_t i = 0; i < count; ++i) add(soup, 0, y, 0);
    for (int i = 0; i <= columns; ++i) add_turned(soup, radius, y, i, columns);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t c = centre + i, a = centre + count + i, b = a + 1;
      soup.triangles.push_back(is_top ? Triangle{a, b, c} : Triangle{b, a, c});
    }
  }
};

// The mesh in which every vertex copies the first vertex within a millionth of its extent.
inline Soup twin_of(Soup soup) {
  Vec3 low = soup.positions[0], high = low;
  for (const Vec3& p : soup.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double near_m = 1e-6 * (high - low).maxCoeff();
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if ((soup.positions[i] - soup.positions[j]).cwiseAbs().maxCoeff() > near_m) continue;
      soup.positions[i] = soup.positions[j];
      break;
    }
  }
  return soup;
}

}  // namespace palpate::test
