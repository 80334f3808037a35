#pragma once
/// Conditions written by hand, over the parameters of bodies that need no joints.

#include "balance/foundation/base/rotation.hpp"
#include "balance/synthesis/conditions/conditions.hpp"

#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace hand_made {

using namespace balance;

/// Bodies "1", "2", … of mass 1 and size 1.
inline Mechanism bodies(SpaceKind space, int count) {
  Mechanism m;
  m.space = space;
  m.bodies.resize(static_cast<std::size_t>(count) + 1);
  for (int b = 1; b <= count; ++b) {
    Body& body = m.bodies[static_cast<std::size_t>(b)];
    body.name = std::to_string(b);
    body.mass = 1;
    body.com = Vector3(0.1, 0.2, space == SpaceKind::planar ? 0 : 0.3);
    body.inertia.diagonal() = space == SpaceKind::planar ? Vector3(0, 0, 0.2) : Vector3(0.2, 0.25, 0.3);
    body.points.push_back({"P", Vector3(1, 0, 0)});
  }
  return m;
}

using Terms = std::vector<std::pair<std::string, double>>;

inline Eigen::Index find(const Conditions& conditions, const std::string& name) {
  for (std::size_t p = 0; p < conditions.parameters.size(); ++p)
    if (conditions.parameters[p].name == name) return static_cast<Eigen::Index>(p);
  throw std::invalid_argument(name);
}

inline Conditions with_matrix(const Mechanism& mechanism, const MatrixX& matrix) {
  Conditions c;
  c.status = ConditionsStatus::done;
  c.parameters = dynamics::list_parameters(mechanism, dynamics::FreeSprings(mechanism.springs.size(), true));
  c.matrix = matrix;
  c.rank = static_cast<int>(matrix.rows());
  c.row_scales = VectorX::Ones(matrix.rows());
  return c;
}

inline Conditions make_conditions(const Mechanism& mechanism, const std::vector<Terms>& rows) {
  Conditions c = with_matrix(mechanism, MatrixX());
  c.matrix = MatrixX::Zero(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(c.parameters.size()));
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (const auto& [name, value] : rows[r]) c.matrix(static_cast<Eigen::Index>(r), find(c, name)) += value;
  c.row_scales = VectorX::Ones(c.matrix.rows());
  c.rank = static_cast<int>(rows.size());
  return c;
}

/// Numbers of its own, the same with every standard library.
class RandomNumbers {
 public:
  explicit RandomNumbers(unsigned seed) : bits_(seed) {}
  double number(double low, double high) {
    return low + (high - low) * (static_cast<double>(bits_()) + 0.5) / 4294967296.0;
  }
  Vector3 place(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
  MatrixX matrix(Eigen::Index rows, Eigen::Index columns) {
    return MatrixX::NullaryExpr(rows, columns, [&] { return number(-1, 1); });
  }

 private:
  std::mt19937 bits_;
};

/// Bodies of random shape: each a cloud of heavy points, so that it is physical by construction.
inline void reshape(Mechanism& m, RandomNumbers& random) {
  for (std::size_t b = 1; b < m.bodies.size(); ++b) {
    Body& body = m.bodies[b];
    const Vector3 flat(1, 1, m.space == SpaceKind::planar ? 0 : 1);
    body.mass = random.number(0.2, 3);
    body.com = random.place(1).cwiseProduct(flat);
    Matrix3 second = Matrix3::Zero();
    for (int i = 0; i < 5; ++i) {
      const Vector3 r = random.place(0.8);
      second += 0.2 * body.mass * r * r.transpose();
    }
    body.inertia = second.trace() * Matrix3::Identity() - second;
    if (m.space == SpaceKind::planar) body.inertia = Vector3(0, 0, body.inertia(2, 2)).asDiagonal();
  }
}

}  // namespace hand_made
