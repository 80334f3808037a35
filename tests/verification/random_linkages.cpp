#include "random_linkages.hpp"

#include "balance/foundation/base/rotation.hpp"

#include <random>

namespace natural_tests {

using namespace balance;

namespace {

class Maker {
 public:
  Maker(const Recipe& recipe, std::uint32_t seed) : random_(seed) {
    m_.name = "random linkage " + std::to_string(seed);
    m_.bodies.emplace_back();
    m_.bodies[0].name = "ground";
    origins_.push_back(Vector3::Zero());
    turns_.push_back(0);
    for (int k = 0; k < recipe.cranks; ++k) {
      const int crank = add_body();
      add_joint(JointType::revolute, model::ground, crank, crank % 2 == 0);
    }
    for (int k = 0; k < recipe.dyads; ++k) add_dyad(number(0, 1) < recipe.sliders);
    m_.coordinates = list_coordinates(SpaceKind::planar, m_.joints);
    if (recipe.gears && recipe.cranks > 1) m_.couplings.push_back({1, 0, number(-2, 2), 0});
    for (int c = 0; c < static_cast<int>(m_.coordinates.size()); ++c) m_.assembly.push_back({c, 0});
    const int degrees = recipe.cranks - static_cast<int>(m_.couplings.size());
    for (int k = 0; k < degrees; ++k) m_.actuators.push_back(k);
  }

  Mechanism take() { return std::move(m_); }

 private:
  double number(double low, double high) { return low + (high - low) * static_cast<double>(random_()) / 4294967296.0; }
  int pick(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  Vector3 anywhere() { return {number(-1, 1), number(-1, 1), 0}; }

  int add_body() {
    Body body;
    body.name = "link" + std::to_string(m_.bodies.size());
    body.mass = number(0.5, 2);
    body.com = 0.4 * anywhere();
    body.inertia(2, 2) = number(0.01, 0.1);
    m_.bodies.push_back(body);
    origins_.push_back(anywhere());
    turns_.push_back(number(-3, 3));
    return static_cast<int>(m_.bodies.size()) - 1;
  }

  Vector3 on_body(int b, const Vector3& world) const {
    return rotation_about(Vector3::UnitZ(), -turns_[static_cast<std::size_t>(b)]) *
           (world - origins_[static_cast<std::size_t>(b)]);
  }

  /// Somewhere in the world, where both bodies have a point.
  void add_joint(JointType type, int first, int second, bool swapped) {
    if (swapped) std::swap(first, second);
    Joint joint;
    joint.name = "J" + std::to_string(m_.joints.size() + 1);
    joint.type = type;
    joint.first = first;
    joint.second = second;
    const Vector3 place = anywhere();
    joint.point_first = on_body(first, place);
    joint.point_second = on_body(second, place);
    joint.axis = type == JointType::revolute ? Vector3(0, 0, 1) : anywhere().normalized();
    joint.rotation = rotation_about(Vector3::UnitZ(),
                                    turns_[static_cast<std::size_t>(second)] - turns_[static_cast<std::size_t>(first)]);
    m_.joints.push_back(joint);
  }

  void add_dyad(bool slides) {
    const int there = static_cast<int>(m_.bodies.size());
    // the first ends on the newest link and the ground or another: nothing stays a mere pendulum, and ternary links arise
    const int p = there - 1;
    int q = pick(there - 1);
    if (there == 3 && m_.joints.size() == 2) q = 1;  // a five-bar's dyad joins the cranks
    const int a = add_body(), b = add_body();
    JointType types[] = {JointType::revolute, JointType::revolute, JointType::revolute};
    if (slides) types[pick(3)] = pick(4) > 0 ? JointType::prismatic : JointType::revolute;
    add_joint(types[0], p, a, pick(2) == 0);
    add_joint(types[1], a, b, pick(2) == 0);
    add_joint(types[2], b, q, pick(2) == 0);
  }

  std::mt19937 random_;
  Mechanism m_;
  std::vector<Vector3> origins_;
  std::vector<double> turns_;
};

}  // namespace

Mechanism random_linkage(const Recipe& recipe, std::uint32_t seed) { return Maker(recipe, seed).take(); }

}  // namespace natural_tests
