#include "balance/natural/momentum.hpp"

#include "balance/base/factorizations.hpp"
#include "balance/natural/random_walk.hpp"

#include <stdexcept>

namespace balance::natural {

namespace {

/// A complex matrix as a real one: z ↦ w z for columns (Re z, Im z).
MatrixX to_real_matrix(const Eigen::MatrixXcd& A) {
  MatrixX out(2 * A.rows(), 2 * A.cols());
  out << A.real(), -A.imag(), A.imag(), A.real();
  return out;
}

/// Per body and place the weights of the points that carry its mass: those of the mass matrix.
AffineForm make_carried_point_form(const NaturalModel& model, std::size_t b, Complex r) {
  const BodyPoints& own = model.basic.bodies[b];
  if (!own.has_mass_triangle) return model.bodies[b].place(r);
  const Complex a = own.points[0].position, u = own.points[1].position - a, v = own.points[2].position - a;
  const double area = cross(u, v), second = cross(r - a, v) / area, third = cross(u, r - a) / area;
  return {{}, {{own.points[0].point, 1 - second - third}, {own.points[1].point, second}, {own.points[2].point, third}}};
}

/// p = Σ over functions and parameters of coefficient · π · ġ. Functions: moving points, rims of discs.
class MomentumCoefficients {
 public:
  MomentumCoefficients(const Mechanism& mechanism, const NaturalModel& model) : m_(mechanism), model_(model) {
    const auto functions = static_cast<Eigen::Index>(m_.discs.size()) + model.basic.moving;
    const auto owners = m_.bodies.size() - 1 + m_.attachments.size() + m_.discs.size();
    matrix_.setZero(functions, 4 * static_cast<Eigen::Index>(owners));
    Eigen::Index column = 0;
    for (std::size_t b = 1; b < m_.bodies.size(); ++b, column += 4) fixed_to(b, column);
    for (const Attachment& extra : m_.attachments) {
      fixed_to(static_cast<std::size_t>(extra.body), column);
      column += 4;
    }
    for (std::size_t d = 0; d < m_.discs.size(); ++d, column += 4) disc(d, column);
  }

  const Eigen::MatrixXcd& matrix() const { return matrix_; }

 private:
  void put(const AffineForm& form, Eigen::Index column) {
    for (const PointTerm& term : form.terms)
      if (term.point < model_.basic.moving) matrix_(term.point, column) += term.weight;
  }

  /// m ȯ + mx ė + my i ė, in units of length.
  void fixed_to(std::size_t b, Eigen::Index column) {
    const AffineForm origin = make_carried_point_form(model_, b, 0);
    put(origin, column);
    put(make_carried_point_form(model_, b, 1) - origin, column + 1);
    put(make_carried_point_form(model_, b, imaginary) - origin, column + 2);
  }

  void disc(std::size_t d, Eigen::Index column) {
    const Disc& disc = m_.discs[d];
    put(make_carried_point_form(model_, static_cast<std::size_t>(disc.body),
                                to_complex(disc.position, model_.length())),
        column);
    const Eigen::Index rim = model_.basic.moving + static_cast<Eigen::Index>(d);
    matrix_(rim, column + 1) = 1;
    matrix_(rim, column + 2) = imaginary;
  }

  const Mechanism& m_;
  const NaturalModel& model_;
  Eigen::MatrixXcd matrix_;
};

/// Velocities of points and rims in the motions that one configuration allows.
Eigen::MatrixXcd sample_velocities(const NaturalModel& model, const RandomWalk& walk) {
  const MatrixX& motions = walk.motions();
  const int moving = model.basic.moving;
  Eigen::MatrixXcd out(moving + static_cast<Eigen::Index>(model.rotors.size()), motions.cols());
  for (Eigen::Index c = 0; c < motions.cols(); ++c) {
    for (int k = 0; k < moving; ++k) out(k, c) = Complex(motions(2 * k, c), motions(2 * k + 1, c));
    for (std::size_t d = 0; d < model.rotors.size(); ++d) {
      const ScalarAffineForm& angle = model.rotors[d].angle;
      double rate = 0;
      for (const ScalarTerm& term : angle.terms) rate += term.coefficient * motions(2 * moving + term.scalar, c);
      out(moving + static_cast<Eigen::Index>(d), c) =
          imaginary * rate * make_unit_complex(angle.at(walk.position().scalars));
    }
  }
  return out;
}

/// Orthonormal basis of the null space, as real vectors (Re, Im).
MatrixX compute_null_space(const MatrixX& A, Eigen::Index columns) {
  if (A.rows() == 0) return MatrixX::Identity(columns, columns);
  const SingularValueDecomposition svd(A, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  const VectorX& values = svd.singularValues();
  while (rank < values.size() && values[rank] > 1e-10 * values[0]) ++rank;
  return svd.matrixV().rightCols(columns - rank);
}

constexpr double dependence_tolerance =
    1e-10;  // singular value, against the largest, below which functions are dependent

}  // namespace

std::vector<PointCoefficient> point_coefficients(const Mechanism& mechanism) {
  InitialCoordinates start;
  start.coordinates.assign(mechanism.coordinates.size(), 0);
  const NaturalModel model = build_model(mechanism, {}, false, start);
  std::vector<PointCoefficient> out;
  for (int k = 0; k < model.basic.count(); ++k)
    out.push_back({model.basic.names[static_cast<std::size_t>(k)], k >= model.basic.moving, {}});
  for (const MassEntry& entry : model.mass) out[static_cast<std::size_t>(entry.column)].coefficient += entry.value;
  return out;
}

ForceConditions force_conditions(const Mechanism& mechanism, const InitialCoordinates& start) {
  if (mechanism.space != SpaceKind::planar)
    throw std::invalid_argument("natural coordinates are for planar mechanisms, this one is spatial");
  ForceConditions found;
  const NaturalModel model = build_model(mechanism, {}, false, start);
  RandomWalk walk(model);
  if (!walk.begin()) {
    found.reason = "the mechanism cannot be assembled or cannot move";
    return found;
  }
  const Eigen::MatrixXcd coefficients = MomentumCoefficients(mechanism, model).matrix();
  const Eigen::Index functions = coefficients.rows();
  // what the joints let the points' velocities be, if lengths are not special
  MatrixX basis = compute_null_space(to_real_matrix(velocity_relations(mechanism, model)), 2 * functions);
  found.points = static_cast<int>(functions);
  found.relations = static_cast<int>(functions - basis.cols() / 2);
  // and what they are
  MatrixX seen(basis.cols(), 0);
  while (seen.cols() < 3 * basis.cols() + 8) {
    const MatrixX more = basis.transpose() * to_real_matrix(sample_velocities(model, walk));
    MatrixX all(seen.rows(), seen.cols() + more.cols());
    all << seen, more;
    seen = all;
    if (!walk.next()) {
      found.reason = "the mechanism has too little room to move";
      return found;
    }
  }
  const SingularValueDecomposition svd(seen, Eigen::ComputeFullU);
  const VectorX& values = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > dependence_tolerance * values[0]) ++rank;
  found.singular_value_ratio =
      rank > 0 ? values[rank - 1] / std::max(rank < values.size() ? values[rank] : 0, 1e-16 * values[0]) : 0;
  found.special_relations = static_cast<int>((basis.cols() - rank) / 2);
  basis = MatrixX(basis * svd.matrixU().leftCols(rank));
  // Re(v C) π = 0 for each of these velocities; the span holds i v with every v, which gives the imaginary part
  const MatrixX rows = basis.transpose() * to_real_matrix(coefficients.conjugate());
  MatrixX conditions = rows.leftCols(coefficients.cols());
  const SingularValueDecomposition reduced(conditions, Eigen::ComputeThinV);
  Eigen::Index count = 0;
  const VectorX& sizes = reduced.singularValues();
  while (count < sizes.size() && sizes[count] > dependence_tolerance * sizes[0]) ++count;
  found.matrix = reduced.matrixV().leftCols(count).transpose();
  for (Eigen::Index c = 0; c < found.matrix.cols(); ++c)  // m in kg, mx and my in kg m
    if (c % 4 == 1 || c % 4 == 2) found.matrix.col(c) /= model.length();
  found.is_valid = true;
  return found;
}

}  // namespace balance::natural
