#pragma once

// Random scenes in which the place nearest to the goal is hard to find, each with a proxy of
// suitable size, and a hand that provokes failures there.

#include <cstdint>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include "haptics/proxy/god_object.h"
#include "tests/helpers/exact_judge.h"
#include "tests/helpers/random.h"
#include "tests/helpers/worlds.h"

namespace palpate::test {

struct RestScene {
  Soup soup;
  double radius_m = 0.0;          // radius of the proxy
  std::vector<Vec3> starts = {};  // initial proxy positions; empty: any place with clearance
  std::vector<Vec3> aims = {};    // further targets besides vertices, edges and faces
  double grid_m = 0.0;            // spacing of the vertices' and the goals' grid; 0: no grid
};

enum class ProxyKind : std::uint8_t { kPoint, kSphere };

struct RestClass {
  const char* name;
  ProxyKind proxy;
  RestScene (*make)(ProxyKind proxy, Random& random);
  double most_capped;  // largest accepted fraction of capped ticks among the ticks in contact

  std::string full_name() const;  // name and proxy kind
};

inline void PrintTo(const RestClass& rest_class, std::ostream* out) {
  *out << rest_class.full_name();
}

// All classes of rest scenes. They include the hard scenes of the leak test.
std::span<const RestClass> rest_classes();

// The rest classes, and classes of meshes so fine that judging rests there would take a long time.
std::vector<RestClass> restless_classes();

// The classes whose spheres are up to ten thousand times larger than the edges.
std::vector<RestClass> large_sphere_classes();

// A room with plane walls: the convex hull of random points in single precision. Exact signs
// confirm that it is convex, and walls that share an edge meet at an angle of more than a degree.
// Faces look inwards.
Soup convex_room(Random& random);

// A hand that plunges, slides, arrives in the plane of a face, aims exactly at vertices and edges,
// jumps, moves at a steady speed from place to place, and rests for some ticks wherever it is.
// Solver frame.
class RestHand {
 public:
  // The triangles must outlive the hand.
  RestHand(const std::vector<Corners>& triangles, std::vector<Vec3> aims, double radius_m,
           double stand_off_m, double grid_m, const Vec3& start, Random& random);
  Vec3 next_goal(const ProxyState& state);

  // The hand stops resting and aiming. From now on, each tick moves the goal.
  void never_rest() { is_restless_ = true; }

 private:
  enum class Habit : std::uint8_t {
    kPlunge,
    kSlide,
    kGraze,
    kAim,
    kPress,
    kJump,
    kWander,
    kTour,
    kCount
  };

  void choose(const ProxyState& state);
  Vec3 place_of_interest();
  Vec3 vertex_or_edge();
  Vec3 graze_start();
  Vec3 make_goal(const ProxyState& state);
  const Corners& some_triangle();
  Vec3 on_grid(const Vec3& p) const;
  double log_uniform(double low, double high);

  const std::vector<Corners>* triangles_;
  std::vector<Vec3> aims_;
  double radius_m_;
  double stand_off_m_;
  double grid_m_;
  Random* random_;
  Vec3 low_, high_;
  double size_m_;
  Vec3 goal_;
  Vec3 aim_;
  Vec3 heading_;
  double pace_m_ = 0.0;
  double depth_m_ = 0.0;
  Habit habit_ = Habit::kWander;
  int ticks_left_ = 0;
  int rest_left_ = 0;
  bool is_restless_ = false;
  int stage_ = 0;
};

}  // namespace palpate::test
