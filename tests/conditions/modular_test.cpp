// The modular strategy (P0 section 2.2) against the complete conditions and against P0's propositions.

#include "chain_forces.hpp"
#include "parallel.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/interface/specification/read_spec.hpp"
#include "balance/synthesis/conditions/goal_rows.hpp"
#include "balance/synthesis/conditions/modular_conditions.hpp"

#include <doctest/doctest.h>

using namespace hand_made;

namespace {

constexpr Goal statics{GoalKind::statics}, no_velocity{GoalKind::gyroscopic};

Mechanism config(const std::string& name) {
  return read_spec_file(std::string(BALANCE_CONFIGS) + "/" + name).mechanism;
}

MatrixX in_natural_units(const Mechanism& mechanism, const Conditions& conditions) {
  MatrixX rows = conditions.matrix * NaturalUnits(mechanism, conditions.parameters).parameter.asDiagonal();
  for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r) /= rows.row(r).norm();
  return rows;
}

/// Orthonormal basis of the row space, as columns.
MatrixX basis(const MatrixX& rows) {
  const Eigen::HouseholderQR<MatrixX> qr(rows.transpose());
  return qr.householderQ() * MatrixX::Identity(rows.cols(), rows.rows());
}

/// How far unit rows of `part` reach out of the row space of `all`.
double outside(const MatrixX& part, const MatrixX& all) {
  if (part.rows() == 0) return 0;
  if (all.rows() == 0) return 1;
  const MatrixX Q = basis(all);
  return (part - part * Q * Q.transpose()).cwiseAbs().maxCoeff();
}

/// Every solution of the modular conditions solves the complete ones.
void check_sufficient(const Mechanism& m, const Goal& goal) {
  const Conditions modular = derive_modular_conditions(m, {goal}), complete = derive_conditions(m, {goal});
  INFO(modular.reason);
  REQUIRE(modular.status == ConditionsStatus::done);
  REQUIRE(complete.status == ConditionsStatus::done);
  CHECK(modular.rank >= complete.rank);
  // Both are known to about the gap's lower end.
  CHECK(outside(in_natural_units(m, complete), in_natural_units(m, modular)) < 1e-7);
}

/// The chains with what is left over feel the forces of the whole mechanism, for parameters that nobody balanced.
template <class S>
void check_together(const Mechanism& m, std::uint64_t seed) {
  const ChainSplit split = split_into_chains(m);
  REQUIRE(split.failure_reason.empty());
  REQUIRE(!split.is_serial);
  Moving<S> moving(m, seed);
  const auto inertial =
      static_cast<Eigen::Index>(kinematics::compile_tree<S>(m, {}).mass_elements.size()) * S::inertial_parameter_count;
  for (int k = 0; k < 3; ++k) {
    REQUIRE(moving.next());
    const MatrixX whole = moving.forces(1, m.gravity);
    MatrixX parts = whole * split.unassigned.topLeftCorner(inertial, inertial);
    for (const Chain& chain : split.chains) {
      const MatrixX own = moving.chain_forces(chain, 1, m.gravity);
      parts += own * chain.parameters.topLeftCorner(own.cols(), inertial);
    }
    // Loops are closed to 1e-12; accelerations of nearly stretched legs magnify that.
    CHECK((whole - parts).cwiseAbs().maxCoeff() < 1e-8 * whole.cwiseAbs().maxCoeff());
  }
}

/// Proposition 2.3 as it is true: forces of a mechanism whose chains are balanced depend on the accelerations of the chains'
/// joints, and of what carries the rest, but not on velocities.
template <class S>
void check_gyroscopic(const Mechanism& m, std::uint64_t seed) {
  const Conditions modular = derive_modular_conditions(m, {no_velocity});
  INFO(modular.reason);
  REQUIRE(modular.status == ConditionsStatus::done);
  const VectorX units = NaturalUnits(m, modular.parameters).parameter;
  const MatrixX Q = basis(in_natural_units(m, modular));
  numerics::UniformRandom random(seed);
  const VectorX any = random.sample_normal(units.size());
  const VectorX unbalanced = units.cwiseProduct(any), balanced = units.cwiseProduct(any - Q * (Q.transpose() * any));
  CHECK(scaled_residuals(modular, balanced).cwiseAbs().maxCoeff() < 1e-9);
  const ChainSplit split = split_into_chains(m);
  const auto inertial =
      static_cast<Eigen::Index>(kinematics::compile_tree<S>(m, {}).mass_elements.size()) * S::inertial_parameter_count;
  Moving<S> moving(m, seed);
  for (int k = 0; k < 3; ++k) {
    REQUIRE(moving.next());
    const MatrixX actual = moving.forces(1, Vector3::Zero());
    MatrixX slow = moving.forces(0, Vector3::Zero()) * split.unassigned.topLeftCorner(inertial, inertial);
    for (const Chain& chain : split.chains) {
      const MatrixX own = moving.chain_forces(chain, 0, Vector3::Zero());
      slow += own * chain.parameters.topLeftCorner(own.cols(), inertial);
    }
    const MatrixX velocity_terms = actual - slow;
    const double size = (actual.cwiseAbs() * balanced.head(inertial).cwiseAbs()).maxCoeff();
    CHECK((velocity_terms * balanced.head(inertial)).cwiseAbs().maxCoeff() < 1e-7 * size);
    CHECK((velocity_terms * unbalanced.head(inertial)).cwiseAbs().maxCoeff() > 1e-4 * size);
  }
}

/// A mechanism of the library with weight, whatever its spec says.
Mechanism heavy(const std::string& name) {
  Mechanism m = config(name);
  if (m.gravity.norm() == 0) m.gravity = Vector3(0, -9.81, 0);
  return m;
}

}  // namespace

TEST_CASE("the 5R is asked for eight static conditions where six are enough (P0 eq. 95)") {
  const Mechanism m = config("5r.yaml");
  const Conditions modular = derive_modular_conditions(m, {statics}), complete = derive_conditions(m, {statics});
  REQUIRE(modular.status == ConditionsStatus::done);
  CHECK(modular.rank == 8);
  CHECK(complete.rank == 6);
  check_sufficient(m, statics);
}

TEST_CASE("gyroscopically balanced chains make a gyroscopically balanced 5R where nothing is shared") {
  // The complete conditions write the efforts in the accelerations of the tree's joints, which are the two chains', and the
  // payload with the body that carries it; half of it on the other chain is another way of writing.
  Mechanism m = config("5r.yaml");
  std::erase_if(m.attachments, [](const Attachment& a) { return a.kind == AttachmentKind::payload; });
  check_sufficient(m, no_velocity);
}

TEST_CASE("the 5R of P0 eq. 95 meets the modular conditions") {
  const Mechanism m = config("5r-balanced.yaml");
  for (const Goal& goal : {statics, no_velocity}) {
    const Conditions modular = derive_modular_conditions(m, {goal});
    REQUIRE(modular.status == ConditionsStatus::done);
    CHECK(scaled_residuals(modular, dynamics::parameter_values(m)).cwiseAbs().maxCoeff() < 1e-12);
    // And with half as much payload again it does not.
    Mechanism other = m;
    for (Attachment& a : other.attachments)
      if (a.kind == AttachmentKind::payload) a.mass *= 1.5;
    CHECK(scaled_residuals(modular, dynamics::parameter_values(other)).cwiseAbs().maxCoeff() > 1e-3);
  }
}

TEST_CASE("the shares of a triangular platform are barycentric") {
  Mechanism m = heavy("3rrr.yaml");
  const auto weight_at = [&](const Vector3& com) {
    m.bodies.back().com = com;
    VectorX shares(3);
    const ChainSplit split = split_into_chains(m);
    REQUIRE(split.chains.size() == 3);
    for (int i = 0; i < 3; ++i) shares[i] = split.chains[static_cast<std::size_t>(i)].mechanism.attachments.back().mass;
    return shares;
  };
  // At its joints C1 (0.15, 0), C2 (0, 0), C3 (0.075, 0.1299038) and in the middle (P3 Table 1).
  CHECK((weight_at({0.15, 0, 0}) - Vector3(3, 0, 0)).norm() < 1e-12);
  CHECK((weight_at({0, 0, 0}) - Vector3(0, 3, 0)).norm() < 1e-12);
  CHECK((weight_at({0.075, 0.15 / (2 * std::sqrt(3.0)), 0}) - Vector3(1, 1, 1)).norm() < 1e-12);
}

TEST_CASE("chains and what is left over are together the whole mechanism") {
  check_together<kinematics::Planar>(heavy("3rrr.yaml"), 1);
  check_together<kinematics::Planar>(config("5r.yaml"), 1);
  check_together<kinematics::Planar>(config("geared-five-bar.yaml"), 1);
  check_together<kinematics::Spatial>(config("delta.yaml"), 1);
  check_together<kinematics::Spatial>(config("stewart.yaml"), 1);
  for (unsigned seed = 1; seed <= 8; ++seed) {
    CAPTURE(seed);
    ParallelMaker flat(SpaceKind::planar, seed), deep(SpaceKind::spatial, seed), sliding(SpaceKind::planar, seed);
    flat.make(3 + static_cast<int>(seed % 2));
    check_together<kinematics::Planar>(flat.fitted(), seed);
    sliding.slide_on_platform(static_cast<int>(seed % 3)).make(3);
    check_together<kinematics::Planar>(sliding.fitted(), seed);
    deep.make(3 + static_cast<int>(seed % 3));
    check_together<kinematics::Spatial>(deep.fitted(), seed);
  }
}

TEST_CASE("statically balanced chains make a statically balanced mechanism (P0 Proposition 2.2)") {
  for (const char* name : {"3rrr.yaml", "delta.yaml", "four-bar.yaml", "slider-crank.yaml", "whitworth.yaml"}) {
    CAPTURE(name);
    check_sufficient(heavy(name), statics);
  }
  for (unsigned seed = 1; seed <= 6; ++seed) {
    CAPTURE(seed);
    ParallelMaker flat(SpaceKind::planar, seed), deep(SpaceKind::spatial, seed), sliding(SpaceKind::planar, seed);
    flat.make(3 + static_cast<int>(seed % 2));
    check_sufficient(flat.fitted(), statics);
    sliding.slide_on_platform(1).make(3);
    check_sufficient(sliding.fitted(), statics);
    deep.make(3 + static_cast<int>(seed % 2));
    check_sufficient(deep.fitted(), statics);
  }
}

TEST_CASE("gyroscopically balanced chains keep no velocity terms in their joints' accelerations (P0 Proposition 2.3)") {
  check_gyroscopic<kinematics::Planar>(config("5r.yaml"), 1);
  check_gyroscopic<kinematics::Planar>(heavy("3rrr.yaml"), 1);
  check_gyroscopic<kinematics::Spatial>(config("delta.yaml"), 1);
  for (unsigned seed = 1; seed <= 3; ++seed) {
    CAPTURE(seed);
    ParallelMaker flat(SpaceKind::planar, seed), deep(SpaceKind::spatial, seed);
    flat.make(3);
    check_gyroscopic<kinematics::Planar>(flat.fitted(), seed);
    deep.make(3);
    check_gyroscopic<kinematics::Spatial>(deep.fitted(), seed);
  }
}

TEST_CASE("for a serial mechanism the modular strategy is the ordinary one") {
  const Mechanism m = config("planar-rrr.yaml");
  for (const Goal& goal : {statics, no_velocity, Goal{GoalKind::gyroscopic_independent}}) {
    const Conditions modular = derive_modular_conditions(m, {goal}), complete = derive_conditions(m, {goal});
    REQUIRE(modular.status == ConditionsStatus::done);
    CHECK(modular.matrix == complete.matrix);
    REQUIRE(!modular.notes.empty());
    CHECK(modular.notes[0] == "there is no loop: the modular strategy is the ordinary one");
  }
}

TEST_CASE("goals that balanced chains cannot promise are refused with a reason") {
  const Mechanism m = config("5r.yaml");
  for (const Goal& goal : {Goal{GoalKind::force}, Goal{GoalKind::decoupled}, Goal{GoalKind::statics, true},
                           Goal{GoalKind::gyroscopic_independent}}) {
    const Conditions modular = derive_modular_conditions(m, {statics, goal});
    CHECK(modular.status == ConditionsStatus::mismatch);
    CHECK(modular.reason.find(goal_name(goal)) != std::string::npos);
  }
}

TEST_CASE("a mechanism that does not fall apart at one body is not split") {
  // Two rockers, both jointed to the ground, with two parallel couplers: taking a rocker out leaves one piece.
  Mechanism m = bodies(SpaceKind::planar, 4);
  const auto join = [&](int first, int second) {
    Joint joint;
    joint.name = "J" + std::to_string(m.joints.size());
    joint.first = first, joint.second = second;
    m.joints.push_back(joint);
  };
  join(model::ground, 1), join(model::ground, 2), join(1, 3), join(3, 2), join(1, 4), join(4, 2);
  m.coordinates = list_coordinates(m.space, m.joints);
  const Conditions modular = derive_modular_conditions(m, {statics});
  CHECK(modular.status == ConditionsStatus::mismatch);
  CHECK(modular.reason.find("cannot be split") != std::string::npos);
}
