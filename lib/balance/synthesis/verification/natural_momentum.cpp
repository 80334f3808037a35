#include "balance/synthesis/verification/natural_momentum.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/random.hpp"
#include "balance/synthesis/verification/natural_equations.hpp"

#include <cmath>
#include <numeric>
#include <stdexcept>

namespace balance::verification::natural {

/// Random walk through the configurations that are connected to the first one without passing a singular one.
class RandomWalk {
 public:
  /// @param model must outlive the walk
  explicit RandomWalk(const NaturalModel& model);

  /// Finds a configuration that meets the constraints, near the model's start.
  bool begin();
  /// Moves on to another one, sufficiently far away.
  bool next();

  const NaturalCoordinates& position() const { return position_; }
  /// Admissible velocities there: unknowns × freedoms, orthonormal.
  const MatrixX& motions() const { return motions_; }

 private:
  bool compute_motions(const NaturalCoordinates& position, MatrixX& motions, double& margin) const;
  double step();
  void perturb_direction(double amount);
  VectorX random_direction();

  const NaturalModel& model_;
  NaturalKinematicEquations constraints_;
  numerics::UniformRandom random_{1};
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

/// A place of a body as a form of the points that carry its mass, with the weights of the mass matrix.
AffineForm make_carried_point_form(const NaturalModel& model, std::size_t b, Complex r) {
  const BodyPoints& body = model.basic.bodies[b];
  if (!body.has_mass_triangle) return model.bodies[b].place(r);
  const Complex a = body.points[0].position, u = body.points[1].position - a, v = body.points[2].position - a;
  const double area = cross(u, v), second = cross(r - a, v) / area, third = cross(u, r - a) / area;
  return {{},
          {{body.points[0].point, 1 - second - third}, {body.points[1].point, second}, {body.points[2].point, third}}};
}

/// p = Σ over functions and parameters of coefficient · π · ġ. Functions: moving points, rims of discs.
class MomentumCoefficients {
 public:
  MomentumCoefficients(const Mechanism& mechanism, const NaturalModel& model) : mechanism_(mechanism), model_(model) {
    const auto functions = static_cast<Eigen::Index>(mechanism_.discs.size()) + model.basic.moving;
    const auto carrier_count = mechanism_.bodies.size() - 1 + mechanism_.attachments.size() + mechanism_.discs.size();
    matrix_.setZero(functions, 4 * static_cast<Eigen::Index>(carrier_count));
    Eigen::Index column = 0;
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b, column += 4) add_body(b, column);
    for (const Attachment& attachment : mechanism_.attachments) {
      add_body(static_cast<std::size_t>(attachment.body), column);
      column += 4;
    }
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d, column += 4) add_disc(d, column);
  }

  const Eigen::MatrixXcd& matrix() const { return matrix_; }

 private:
  void add_terms(const AffineForm& form, Eigen::Index column) {
    for (const PointTerm& term : form.terms)
      if (term.point < model_.basic.moving) matrix_(term.point, column) += term.weight;
  }

  /// m ȯ + mx ė + my i ė, in units of length.
  void add_body(std::size_t b, Eigen::Index column) {
    const AffineForm origin = make_carried_point_form(model_, b, 0);
    add_terms(origin, column);
    add_terms(make_carried_point_form(model_, b, 1) - origin, column + 1);
    add_terms(make_carried_point_form(model_, b, imaginary) - origin, column + 2);
  }

  void add_disc(std::size_t d, Eigen::Index column) {
    const Disc& disc = mechanism_.discs[d];
    add_terms(make_carried_point_form(model_, static_cast<std::size_t>(disc.body),
                                      to_complex(disc.position, model_.length())),
              column);
    const Eigen::Index rim = model_.basic.moving + static_cast<Eigen::Index>(d);
    matrix_(rim, column + 1) = 1;
    matrix_(rim, column + 2) = imaginary;
  }

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  Eigen::MatrixXcd matrix_;
};

/// Velocities of points and rims in the admissible motions of one configuration.
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
  const numerics::SingularValueDecomposition svd(A, Eigen::ComputeFullV);
  Eigen::Index rank = 0;
  const VectorX& values = svd.singularValues();
  while (rank < values.size() && values[rank] > 1e-10 * values[0]) ++rank;
  return svd.matrixV().rightCols(columns - rank);
}

constexpr double dependence_tolerance =
    1e-10;  // singular value relative to the largest, below which functions are dependent

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
  ForceConditions result;
  const NaturalModel model = build_model(mechanism, {}, false, start);
  RandomWalk walk(model);
  if (!walk.begin()) {
    result.reason = "the mechanism cannot be assembled or cannot move";
    return result;
  }
  const Eigen::MatrixXcd coefficients = MomentumCoefficients(mechanism, model).matrix();
  const Eigen::Index functions = coefficients.rows();
  // relations between the points' velocities that the joints impose for generic lengths
  MatrixX basis = compute_null_space(to_real_matrix(velocity_relations(mechanism, model)), 2 * functions);
  result.points = static_cast<int>(functions);
  result.relations = static_cast<int>(functions - basis.cols() / 2);
  // and those of the given lengths
  MatrixX samples(basis.cols(), 0);
  while (samples.cols() < 3 * basis.cols() + 8) {
    const MatrixX new_samples = basis.transpose() * to_real_matrix(sample_velocities(model, walk));
    MatrixX extended(samples.rows(), samples.cols() + new_samples.cols());
    extended << samples, new_samples;
    samples = extended;
    if (!walk.next()) {
      result.reason = "the mechanism has too little room to move";
      return result;
    }
  }
  const numerics::SingularValueDecomposition svd(samples, Eigen::ComputeFullU);
  const VectorX& values = svd.singularValues();
  Eigen::Index rank = 0;
  while (rank < values.size() && values[rank] > dependence_tolerance * values[0]) ++rank;
  result.singular_value_ratio =
      rank > 0 ? values[rank - 1] / std::max(rank < values.size() ? values[rank] : 0, 1e-16 * values[0]) : 0;
  result.special_relations = static_cast<int>((basis.cols() - rank) / 2);
  basis = MatrixX(basis * svd.matrixU().leftCols(rank));
  // Re(v C) π = 0 for each of these velocities; with every v the span contains i v, which gives the imaginary part
  const MatrixX rows = basis.transpose() * to_real_matrix(coefficients.conjugate());
  MatrixX conditions = rows.leftCols(coefficients.cols());
  const numerics::SingularValueDecomposition reduced(conditions, Eigen::ComputeThinV);
  Eigen::Index count = 0;
  const VectorX& reduced_values = reduced.singularValues();
  while (count < reduced_values.size() && reduced_values[count] > dependence_tolerance * reduced_values[0]) ++count;
  result.matrix = reduced.matrixV().leftCols(count).transpose();
  for (Eigen::Index c = 0; c < result.matrix.cols(); ++c)  // m in kg, mx and my in kg m
    if (c % 4 == 1 || c % 4 == 2) result.matrix.col(c) /= model.length();
  result.is_valid = true;
  return result;
}

namespace {

constexpr double max_step = 0.2;
constexpr double min_configuration_distance = 0.5;  // path length between sampled configurations
constexpr double step_per_singular_value =
    0.5;  // maximum step per smallest singular value, so that no step jumps across a singular configuration
constexpr double min_margin_ratio = 0.1;  // minimum of the smallest singular value relative to its maximum so far
constexpr double max_point_distance = 6;  // of points from their start, in characteristic lengths

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
  const numerics::SingularValueDecomposition svd(jacobian, Eigen::ComputeFullV);
  margin = rank_ > 0 ? svd.singularValues()[rank_ - 1] : max_step / step_per_singular_value;
  motions = svd.matrixV().rightCols(model_.unknowns() - rank_);
  return true;
}

VectorX RandomWalk::random_direction() { return (motions_ * random_.sample_point(motions_.cols())).normalized(); }

bool RandomWalk::next() {
  double distance = 0;
  for (int tries = 0; tries < 2000 && distance < min_configuration_distance; ++tries) distance += step();
  return distance >= min_configuration_distance;
}

double RandomWalk::step() {
  const double step_length = std::min(max_step, step_per_singular_value * margin_);
  NaturalCoordinates candidate = position_;
  candidate.add(step_length, direction_);
  bool is_accepted = constraints_.solve_least_norm(candidate, VectorX());
  VectorX displacement;
  if (is_accepted) {
    displacement = subtract_coordinates(candidate, position_, model_.basic.moving);
    is_accepted = (displacement - step_length * direction_).norm() < 0.7 * step_length &&
                  subtract_coordinates(candidate, model_.start, model_.basic.moving).lpNorm<Eigen::Infinity>() <
                      max_point_distance;
  }
  MatrixX motions;
  double margin = 0;
  is_accepted = is_accepted && compute_motions(candidate, motions, margin) &&
                (margin > min_margin_ratio * max_margin_ || margin > margin_);
  if (!is_accepted) {
    perturb_direction(1);
    return 0;
  }
  position_ = candidate;
  motions_ = motions;
  margin_ = margin;
  max_margin_ = std::max(max_margin_, margin);
  direction_ = (motions_ * (motions_.transpose() * direction_)).normalized();
  if (motions_.cols() > 1) perturb_direction(0.3);
  return displacement.norm();
}

/// Amount 1 discards the old direction. With one freedom, reverses it.
void RandomWalk::perturb_direction(double amount) {
  if (motions_.cols() == 1)
    direction_ = -direction_;
  else
    direction_ = ((1 - amount) * direction_ + amount * random_direction()).normalized();
}

namespace {

/// Angles of bodies and discs, and slides: finds which of them stay together, by all linear equations of joints,
/// couplings and discs.
class LinearDependencies {
 public:
  explicit LinearDependencies(const Mechanism& mechanism)
      : mechanism_(mechanism), bodies_(static_cast<int>(mechanism.bodies.size())) {
    discs_ = static_cast<int>(mechanism_.discs.size());
    const int count = bodies_ + discs_ + static_cast<int>(mechanism_.coordinates.size());
    std::vector<Eigen::RowVectorXd> rows;
    const auto unit = [&](int k) { return Eigen::RowVectorXd(Eigen::RowVectorXd::Unit(count, k)); };
    rows.push_back(unit(model::ground));
    for (const Joint& joint : mechanism_.joints)
      if (joint.type == JointType::prismatic || joint.type == JointType::fixed)
        rows.push_back(unit(joint.second) - unit(joint.first));
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
      const Joint& joint = mechanism_.joints[static_cast<std::size_t>(mechanism_.coordinates[c].joint)];
      if (mechanism_.coordinates[c].kind == CoordinateKind::angle)
        rows.push_back(unit(coordinate(static_cast<int>(c))) - unit(joint.second) + unit(joint.first));
    }
    const auto sum = [&](const model::CoordinateCombination& followed) {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(count);
      for (const model::CoordinateTerm& term : followed.terms) row += term.ratio * unit(coordinate(term.coordinate));
      return row;
    };
    for (const Coupling& coupling : mechanism_.couplings)
      rows.push_back(unit(coordinate(coupling.follower)) - coupling.ratio * sum(coupling.leader));
    for (int d = 0; d < discs_; ++d) {
      const Disc& disc = mechanism_.discs[static_cast<std::size_t>(d)];
      rows.push_back(unit(bodies_ + d) - unit(disc.body) - disc.ratio * sum(disc.follows));
    }
    MatrixX matrix(static_cast<Eigen::Index>(rows.size()), count);
    for (std::size_t r = 0; r < rows.size(); ++r) matrix.row(static_cast<Eigen::Index>(r)) = rows[r];
    const Eigen::FullPivLU<MatrixX> lu(matrix);
    null_space_ = lu.kernel();
    if (lu.dimensionOfKernel() == 0) null_space_ = MatrixX::Zero(count, 1);
  }

  int disc(int d) const { return bodies_ + d; }
  int coordinate(int c) const { return bodies_ + discs_ + c; }
  bool is_fixed(int k) const { return is_zero(null_space_.row(k)); }
  bool is_moving_with(int a, int b) const { return is_zero(null_space_.row(a) - null_space_.row(b)); }
  /// Whether a moves `ratio` times as far as b.
  bool is_proportional(int a, int b, double& ratio) const {
    const double squared_norm = null_space_.row(b).squaredNorm();
    if (is_fixed(b)) return false;
    ratio = null_space_.row(a).dot(null_space_.row(b)) / squared_norm;
    return is_zero(null_space_.row(a) - ratio * null_space_.row(b));
  }

 private:
  static bool is_zero(const Eigen::RowVectorXd& row) { return row.lpNorm<Eigen::Infinity>() < 1e-9; }

  const Mechanism& mechanism_;
  int bodies_, discs_;
  MatrixX null_space_;  ///< motions that the linear equations leave free
};

class VelocityRelationBuilder {
 public:
  VelocityRelationBuilder(const Mechanism& mechanism, const NaturalModel& model)
      : mechanism_(mechanism),
        model_(model),
        dependencies_(mechanism),
        moving_(model.basic.moving),
        position_(model.start) {}

  Eigen::MatrixXcd run() {
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b) add_extra_point_relations(b);
    add_direction_relations();
    add_slide_relations();
    Eigen::MatrixXcd out(static_cast<Eigen::Index>(rows_.size()), width());
    for (std::size_t r = 0; r < rows_.size(); ++r) out.row(static_cast<Eigen::Index>(r)) = rows_[r];
    return out;
  }

 private:
  using RowC = Eigen::RowVectorXcd;

  Eigen::Index width() const { return moving_ + static_cast<Eigen::Index>(mechanism_.discs.size()); }

  /// Velocity of a form as a function of the points' velocities.
  RowC velocity(const AffineForm& form) const {
    RowC row = RowC::Zero(width());
    for (const PointTerm& term : form.terms)
      if (term.point < moving_) row[term.point] += term.weight;
    return row;
  }

  void add(const RowC& row) {
    if (numerics::max_abs(row) > 1e-12) rows_.push_back(row);
  }

  void add_extra_point_relations(std::size_t b) {
    const std::vector<BodyPoint>& points = model_.basic.bodies[b].points;
    for (std::size_t k = 2; k < points.size(); ++k)
      add(velocity(model_.bodies[b].place(points[k].position) - AffineForm{{}, {{points[k].point, 1}}}));
  }

  /// Directions of bodies and discs; each one is tied to the first one with which it stays together.
  void add_direction_relations() {
    struct Direction {
      int index;
      RowC velocity;
      Complex value;
    };
    std::vector<Direction> directions;
    for (std::size_t b = 1; b < mechanism_.bodies.size(); ++b)
      directions.push_back(
          {static_cast<int>(b), velocity(model_.bodies[b].direction), model_.bodies[b].direction.at(position_)});
    for (std::size_t d = 0; d < mechanism_.discs.size(); ++d) {
      RowC rim = RowC::Zero(width());
      rim[moving_ + static_cast<Eigen::Index>(d)] = 1;
      directions.push_back({dependencies_.disc(static_cast<int>(d)), rim,
                            make_unit_complex(model_.rotors[d].angle.at(position_.scalars))});
    }
    for (std::size_t k = 0; k < directions.size(); ++k) {
      if (dependencies_.is_fixed(directions[k].index)) {
        add(directions[k].velocity);
        continue;
      }
      for (std::size_t j = 0; j < k; ++j) {
        if (!dependencies_.is_moving_with(directions[k].index, directions[j].index)) continue;
        add(directions[k].velocity - directions[k].value / directions[j].value * directions[j].velocity);
        break;
      }
    }
  }

  /// Gaps along directions that stay together, for slides that move in proportion: s = r s₀ + c. A planar joint's gap
  /// is the sum of two slides, those of others are one.
  void add_slide_relations() {
    struct Slide {
      int index;
      Complex axis;  ///< in the world, at the start
      double length;
    };
    struct Gap {
      int body;
      RowC velocity;              ///< without what slides that do not move contribute
      std::vector<Slide> moving;  ///< its slides that move
    };
    std::vector<Gap> gaps;
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
      if (mechanism_.coordinates[c].kind == CoordinateKind::angle) continue;
      const ConstraintRow& row = model_.coordinates[c].slide;
      const JointId joint = mechanism_.coordinates[c].joint;
      const int body = mechanism_.joints[static_cast<std::size_t>(joint)].first;
      const bool is_second = c > 0 && mechanism_.coordinates[c - 1].joint == joint &&
                             mechanism_.coordinates[c - 1].kind == CoordinateKind::length;
      if (!is_second) gaps.push_back({body, velocity(row.right), {}});
      const Slide slide{dependencies_.coordinate(static_cast<int>(c)), row.left.at(position_), row.value(position_)};
      if (dependencies_.is_fixed(slide.index))
        gaps.back().velocity -= slide.length * turning_velocity(body, slide.axis);
      else
        gaps.back().moving.push_back(slide);
    }
    for (std::size_t k = 0; k < gaps.size(); ++k) {
      RowC relation = gaps[k].velocity;
      bool has_relation = true;
      for (const Slide& slide : gaps[k].moving) {
        bool has_partner = false;
        for (std::size_t j = 0; j < k && !has_partner; ++j) {
          double ratio = 0;
          if (gaps[j].moving.size() != 1 || !dependencies_.is_moving_with(gaps[k].body, gaps[j].body) ||
              !dependencies_.is_proportional(slide.index, gaps[j].moving.front().index, ratio))
            continue;
          const Slide& other = gaps[j].moving.front();
          relation -= ratio * slide.axis / other.axis * gaps[j].velocity +
                      (slide.length - ratio * other.length) * turning_velocity(gaps[k].body, slide.axis);
          has_partner = true;
        }
        has_relation = has_relation && has_partner;
      }
      if (has_relation) add(relation);
    }
  }

  /// Velocity of the tip of a unit vector that turns with a body. @param axis in the world, at the start
  RowC turning_velocity(int body, Complex axis) const {
    const AffineForm direction = model_.bodies[static_cast<std::size_t>(body)].direction;
    return axis / direction.at(position_) * velocity(direction);
  }

  const Mechanism& mechanism_;
  const NaturalModel& model_;
  LinearDependencies dependencies_;
  int moving_;
  NaturalCoordinates position_;
  std::vector<RowC> rows_;
};

}  // namespace

Eigen::MatrixXcd velocity_relations(const Mechanism& mechanism, const NaturalModel& model) {
  return VelocityRelationBuilder(mechanism, model).run();
}

}  // namespace balance::verification::natural
