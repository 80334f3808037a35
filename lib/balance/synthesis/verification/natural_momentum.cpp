#include "balance/synthesis/verification/natural_momentum.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>

namespace balance::natural {

/// Configurations that the constraints allow, connected to a first one without passing a singular one.
class RandomWalk {
 public:
  /// @param model must outlive the walk
  explicit RandomWalk(const NaturalModel& model);

  /// Into a configuration that meets the constraints, near the model's start.
  bool begin();
  /// On to another one, far enough from the last.
  bool next();

  const NaturalCoordinates& position() const { return position_; }
  /// Velocities that the constraints allow there: unknowns × freedoms, orthonormal.
  const MatrixX& motions() const { return motions_; }

 private:
  bool compute_motions(const NaturalCoordinates& position, MatrixX& motions, double& margin) const;
  double step();
  void perturb_direction(double amount);
  VectorX random_direction();

  const NaturalModel& model_;
  NaturalKinematicEquations constraints_;
  std::mt19937_64 random_{1};
  int rank_ = 0;
  NaturalCoordinates position_;
  MatrixX motions_;
  VectorX direction_;
  double margin_ = 0, max_margin_ = 0;
};

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

namespace {

constexpr double max_step = 0.2;
constexpr double min_configuration_distance = 0.5;  // way between configurations that are used
constexpr double step_per_singular_value =
    0.5;  // step per smallest singular value: none can leap over a singular configuration
constexpr double min_margin_ratio = 0.1;  // to a singular one: smallest singular value against the largest such seen
constexpr double max_point_distance = 6;  // points stay within so many characteristic lengths of where they were

VectorX subtract_coordinates(const NaturalCoordinates& a, const NaturalCoordinates& b, int moving) {
  VectorX out(2 * moving + static_cast<Eigen::Index>(a.scalars.size()));
  for (int k = 0; k < moving; ++k) {
    const Complex d = a.points[static_cast<std::size_t>(k)] - b.points[static_cast<std::size_t>(k)];
    out[2 * k] = d.real();
    out[2 * k + 1] = d.imag();
  }
  for (std::size_t s = 0; s < a.scalars.size(); ++s)
    out[2 * moving + static_cast<Eigen::Index>(s)] = a.scalars[s] - b.scalars[s];
  return out;
}

}  // namespace

RandomWalk::RandomWalk(const NaturalModel& model) : model_(model), constraints_(model, {}) {}

bool RandomWalk::begin() {
  position_ = model_.start;
  if (!constraints_.solve_least_norm(position_, VectorX())) return false;
  rank_ = find_generic_constraint_rank(model_, position_);
  if (rank_ == model_.unknowns() || !compute_motions(position_, motions_, margin_)) return false;
  max_margin_ = margin_;
  direction_ = random_direction();
  return true;
}

bool RandomWalk::compute_motions(const NaturalCoordinates& position, MatrixX& motions, double& margin) const {
  const MatrixX jacobian = constraints_.jacobian(position);
  if (!jacobian.allFinite()) return false;
  const SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  margin = rank_ > 0 ? svd.singularValues()[rank_ - 1] : max_step / step_per_singular_value;
  motions = svd.matrixV().rightCols(model_.unknowns() - rank_);
  return true;
}

VectorX RandomWalk::random_direction() {
  VectorX amounts(motions_.cols());
  // written out: the standard's distributions differ between libraries
  for (double& amount : amounts) amount = static_cast<double>(random_() >> 11) * 0x1.0p-52 - 1;
  return (motions_ * amounts).normalized();
}

bool RandomWalk::next() {
  double way = 0;
  for (int tries = 0; tries < 2000 && way < min_configuration_distance; ++tries) way += step();
  return way >= min_configuration_distance;
}

double RandomWalk::step() {
  const double stride = std::min(max_step, step_per_singular_value * margin_);
  NaturalCoordinates there = position_;
  there.add(stride, direction_);
  bool good = constraints_.solve_least_norm(there, VectorX());
  VectorX went;
  if (good) {
    went = subtract_coordinates(there, position_, model_.basic.moving);
    good =
        (went - stride * direction_).norm() < 0.7 * stride &&
        subtract_coordinates(there, model_.start, model_.basic.moving).lpNorm<Eigen::Infinity>() < max_point_distance;
  }
  MatrixX motions;
  double margin = 0;
  good =
      good && compute_motions(there, motions, margin) && (margin > min_margin_ratio * max_margin_ || margin > margin_);
  if (!good) {
    perturb_direction(1);
    return 0;
  }
  position_ = there;
  motions_ = motions;
  margin_ = margin;
  max_margin_ = std::max(max_margin_, margin);
  direction_ = (motions_ * (motions_.transpose() * direction_)).normalized();
  if (motions_.cols() > 1) perturb_direction(0.3);
  return went.norm();
}

/// Amount 1 forgets the old direction, and with one freedom goes back.
void RandomWalk::perturb_direction(double amount) {
  if (motions_.cols() == 1)
    direction_ = -direction_;
  else
    direction_ = ((1 - amount) * direction_ + amount * random_direction()).normalized();
}

namespace {

/// Angles of bodies, angles of discs and slides, and which of them stay together: everything linear that joints, couplings and
/// discs say about them.
class LinearDependencies {
 public:
  explicit LinearDependencies(const Mechanism& mechanism)
      : m_(mechanism), bodies_(static_cast<int>(mechanism.bodies.size())) {
    discs_ = static_cast<int>(m_.discs.size());
    const int count = bodies_ + discs_ + static_cast<int>(m_.coordinates.size());
    std::vector<Eigen::RowVectorXd> rows;
    const auto unit = [&](int k) { return Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(count, k)); };
    rows.push_back(unit(ground));
    for (const Joint& joint : m_.joints)
      if (joint.type == JointType::prismatic || joint.type == JointType::fixed)
        rows.push_back(unit(joint.second) - unit(joint.first));
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c) {
      const Joint& joint = m_.joints[static_cast<std::size_t>(m_.coordinates[c].joint)];
      if (m_.coordinates[c].kind == CoordinateKind::angle)
        rows.push_back(unit(coordinate(static_cast<int>(c))) - unit(joint.second) + unit(joint.first));
    }
    const auto sum = [&](const CoordinateCombination& followed) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count);
      for (const CoordinateTerm& term : followed.terms) row += term.ratio * unit(coordinate(term.coordinate));
      return row;
    };
    for (const Coupling& coupling : m_.couplings)
      rows.push_back(unit(coordinate(coupling.follower)) - coupling.ratio * sum(coupling.leader));
    for (int d = 0; d < discs_; ++d) {
      const Disc& disc = m_.discs[static_cast<std::size_t>(d)];
      rows.push_back(unit(bodies_ + d) - unit(disc.body) - disc.ratio * sum(disc.follows));
    }
    MatrixX matrix(static_cast<Eigen::Index>(rows.size()), count);
    for (std::size_t r = 0; r < rows.size(); ++r) matrix.row(static_cast<Eigen::Index>(r)) = rows[r];
    const Eigen::FullPivLU<MatrixX> lu(matrix);
    free_ = lu.kernel();
    if (lu.dimensionOfKernel() == 0) free_ = MatrixX::Zero(count, 1);
  }

  int disc(int d) const { return bodies_ + d; }
  int coordinate(int c) const { return bodies_ + discs_ + c; }
  bool is_fixed(int k) const { return small(free_.row(k)); }
  bool is_moving_with(int a, int b) const { return small(free_.row(a) - free_.row(b)); }
  /// Whether a moves ratio times as b.
  bool is_proportional(int a, int b, double& ratio) const {
    const double size = free_.row(b).squaredNorm();
    if (is_fixed(b)) return false;
    ratio = free_.row(a).dot(free_.row(b)) / size;
    return small(free_.row(a) - ratio * free_.row(b));
  }

 private:
  static bool small(const Eigen::RowVectorXd& row) { return row.lpNorm<Eigen::Infinity>() < 1e-9; }

  const Mechanism& m_;
  int bodies_, discs_;
  MatrixX free_;  ///< all that the linear equations leave free
};

class VelocityRelationBuilder {
 public:
  VelocityRelationBuilder(const Mechanism& mechanism, const NaturalModel& model)
      : m_(mechanism), model_(model), together_(mechanism), moving_(model.basic.moving), places_(model.start) {}

  Eigen::MatrixXcd run() {
    for (std::size_t b = 1; b < m_.bodies.size(); ++b) extra_points(b);
    directions();
    slides();
    Eigen::MatrixXcd out(static_cast<Eigen::Index>(rows_.size()), width());
    for (std::size_t r = 0; r < rows_.size(); ++r) out.row(static_cast<Eigen::Index>(r)) = rows_[r];
    return out;
  }

 private:
  using RowC = Eigen::RowVectorXcd;

  Eigen::Index width() const { return moving_ + static_cast<Eigen::Index>(m_.discs.size()); }

  /// A form's velocity in terms of the points'.
  RowC velocity(const AffineForm& form) const {
    RowC row = RowC::Zero(width());
    for (const PointTerm& term : form.terms)
      if (term.point < moving_) row[term.point] += term.weight;
    return row;
  }

  void add(const RowC& row) {
    if (max_abs(row) > 1e-12) rows_.push_back(row);
  }

  void extra_points(std::size_t b) {
    const std::vector<BodyPoint>& points = model_.basic.bodies[b].points;
    for (std::size_t k = 2; k < points.size(); ++k)
      add(velocity(model_.bodies[b].place(points[k].position) - AffineForm{{}, {{points[k].point, 1}}}));
  }

  /// Directions of bodies and of discs; each is tied to the first that it stays together with.
  void directions() {
    struct Direction {
      int index;
      RowC velocity;
      Complex now;
    };
    std::vector<Direction> all;
    for (std::size_t b = 1; b < m_.bodies.size(); ++b)
      all.push_back(
          {static_cast<int>(b), velocity(model_.bodies[b].direction), model_.bodies[b].direction.at(places_)});
    for (std::size_t d = 0; d < m_.discs.size(); ++d) {
      RowC rim = RowC::Zero(width());
      rim[moving_ + static_cast<Eigen::Index>(d)] = 1;
      all.push_back(
          {together_.disc(static_cast<int>(d)), rim, make_unit_complex(model_.rotors[d].angle.at(places_.scalars))});
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (together_.is_fixed(all[k].index)) {
        add(all[k].velocity);
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) {
        if (!together_.is_moving_with(all[k].index, all[j].index)) continue;
        add(all[k].velocity - all[k].now / all[j].now * all[j].velocity);
        break;
      }
    }
  }

  /// Gaps s u along directions that stay together, of slides that move in proportion: s = r s₀ + c.
  void slides() {
    struct Slide {
      int index, body;
      AffineForm gap;
      Complex axis;  ///< in the world, now
      double length;
    };
    std::vector<Slide> all;
    for (std::size_t c = 0; c < m_.coordinates.size(); ++c) {
      if (m_.coordinates[c].kind == CoordinateKind::angle) continue;
      const ConstraintRow& row = model_.coordinates[c].slide;
      all.push_back({together_.coordinate(static_cast<int>(c)),
                     m_.joints[static_cast<std::size_t>(m_.coordinates[c].joint)].first, row.right,
                     row.left.at(places_), row.value(places_)});
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Slide& slide = all[k];
      const AffineForm direction = model_.bodies[static_cast<std::size_t>(slide.body)].direction;
      const Complex along = slide.axis / direction.at(places_);
      if (together_.is_fixed(slide.index)) {
        add(velocity(slide.gap) - slide.length * along * velocity(direction));
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) {
        double ratio = 0;
        const Slide& other = all[j];
        if (!together_.is_moving_with(slide.body, other.body) ||
            !together_.is_proportional(slide.index, other.index, ratio))
          continue;
        const double rest = slide.length - ratio * other.length;
        add(velocity(slide.gap) - ratio * slide.axis / other.axis * velocity(other.gap) -
            rest * along * velocity(direction));
        break;
      }
    }
  }

  const Mechanism& m_;
  const NaturalModel& model_;
  LinearDependencies together_;
  int moving_;
  NaturalCoordinates places_;
  std::vector<RowC> rows_;
};

}  // namespace

Eigen::MatrixXcd velocity_relations(const Mechanism& mechanism, const NaturalModel& model) {
  return VelocityRelationBuilder(mechanism, model).run();
}

}  // namespace balance::natural
