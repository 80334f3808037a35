#include "balance/synthesis/formulas/equations_report.hpp"

#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/effort_breakdown.hpp"
#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/dynamics/single_state.hpp"
#include "balance/mechanics/model/mechanism.hpp"
#include "balance/mechanics/model/payload_intervals.hpp"
#include "balance/synthesis/conditions/base_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

namespace balance::formulas {

// Sets entries of equations of motion that are only round-off to 0.

/// Reference magnitudes for the entries of a mechanism's equations.
struct EquationScales {
  double length;          ///< characteristic length [m]
  double gravity_moment;  ///< weight of everything that moves times that length [N m]
  double spring_moment;   ///< of springs rotated by a radian or stretched by that length [N m]
  double load_moment;     ///< of loads at that length [N m]
};

EquationScales compute_equation_scales(const Mechanism& mechanism);

/// @param is_length per row: whether its coordinate is a length
void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_length,
                     dynamics::IndependentTerms& terms);
void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_length, dynamics::RedundantTerms& terms);
void clear_round_off(const EquationScales& scales, dynamics::SpeedTerms& terms);
/// @param is_force per actuator: whether its effort is a force
void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_force,
                     dynamics::EffortBreakdown& breakdown);

/// Clears entries far below the largest one.
void clear_relative_round_off(MatrixX& matrix);

namespace {

/// Relative to the terms of an entry, which are products of a hundred terms with inverses of the closures.
constexpr double relative_entry_tolerance = 1e-12;

void clear_if_round_off(double& value, double size) {
  if (std::abs(value) <= relative_entry_tolerance * size) value = 0;
}

void clear_if_round_off(VectorX& values, const VectorX& sizes) {
  for (Eigen::Index i = 0; i < values.size(); ++i) clear_if_round_off(values[i], sizes[i]);
}

VectorX coordinate_scales(const std::vector<bool>& is_length, double length) {
  VectorX units(static_cast<Eigen::Index>(is_length.size()));
  for (Eigen::Index i = 0; i < units.size(); ++i) units[i] = is_length[static_cast<std::size_t>(i)] ? length : 1;
  return units;
}

/// Mass matrices are positive definite: no entry exceeds the geometric mean of its diagonal ones. A coordinate's rate
/// over its unit is of the order of angular velocities.
void clear_inertia_round_off(const VectorX& units, MatrixX& mass, std::vector<MatrixX>& velocity) {
  const VectorX root = mass.diagonal().cwiseAbs().cwiseSqrt();
  const double largest = root.size() > 0 ? numerics::max_coefficient(root) : 0;
  const Eigen::Index d = std::min(root.size(), units.size());
  for (Eigen::Index r = 0; r < d; ++r)
    for (Eigen::Index s = 0; s < d; ++s) {
      clear_if_round_off(mass(r, s), root[r] * root[s]);
      const double product = std::max(root[r] / units[s], root[s] / units[r]);
      for (std::size_t k = 0; k < velocity.size(); ++k) clear_if_round_off(velocity[k](r, s), largest * product);
    }
}

void clear_static_round_off(const VectorX& units, const EquationScales& scales, dynamics::StaticTerms& static_terms) {
  for (const auto& [term, moment] : {std::pair(&static_terms.weight, scales.gravity_moment),
                                     {&static_terms.springs, scales.spring_moment},
                                     {&static_terms.loads, scales.load_moment}})
    if (term->size() == units.size()) clear_if_round_off(*term, VectorX(moment * units.cwiseInverse()));
}

}  // namespace

EquationScales compute_equation_scales(const Mechanism& mechanism) {
  const double length = characteristic_length(mechanism);
  EquationScales scales{length, total_mass(mechanism) * mechanism.gravity.norm() * length, 0, 0};
  for (const Spring& spring : mechanism.springs) {
    const bool is_angle = spring.is_joint_spring() && !is_length_coordinate(mechanism, spring.coordinate);
    scales.spring_moment += std::abs(spring.stiffness) * (is_angle ? 1 : length * std::max(length, spring.free_length));
    scales.spring_moment += std::abs(spring.preload) * (is_angle ? 1 : length);
  }
  for (const ForceElement& element : mechanism.force_elements)
    if (!element.is_damper()) {
      const bool is_moment = element.is_in_joint() && !is_length_coordinate(mechanism, element.coordinate);
      scales.spring_moment += model::ForceLawOf<double>(element.table).max_force() * (is_moment ? 1 : length);
    }
  for (const Load& load : mechanism.loads)
    for (std::size_t k = 0; k < load.force.size(); ++k)
      scales.load_moment += load.force[k].norm() * length + load.moment[k].norm();
  return scales;
}

void clear_relative_round_off(MatrixX& matrix) {
  const double largest = numerics::max_abs(matrix);
  for (double& value : matrix.reshaped()) clear_if_round_off(value, largest);
}

void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_length,
                     dynamics::IndependentTerms& terms) {
  const VectorX units = coordinate_scales(is_length, scales.length);
  clear_inertia_round_off(units, terms.mass, terms.velocity);
  clear_relative_round_off(terms.viscous);
  clear_relative_round_off(terms.input);
  clear_static_round_off(units, scales, terms.static_terms);
}

void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_length,
                     dynamics::RedundantTerms& terms) {
  const VectorX units = coordinate_scales(is_length, scales.length);
  clear_inertia_round_off(units, terms.mass, terms.velocity);
  clear_static_round_off(units, scales, terms.rest);
  for (MatrixX* matrix : {&terms.viscous, &terms.input, &terms.constraints, &terms.transformation, &terms.discs})
    clear_relative_round_off(*matrix);
  const double largest = numerics::max_abs(terms.transformation);
  for (MatrixX& form : terms.acceleration)
    for (double& value : form.reshaped()) clear_if_round_off(value, largest);
}

void clear_round_off(const EquationScales& scales, dynamics::SpeedTerms& terms) {
  clear_relative_round_off(terms.rows);
  clear_relative_round_off(terms.rates);
  clear_relative_round_off(terms.transformation);
  const double largest = numerics::max_abs(terms.transformation) * std::max(1.0, 1 / scales.length);
  for (MatrixX& form : terms.acceleration)
    for (double& value : form.reshaped()) clear_if_round_off(value, largest);
  const double inertia =
      std::max(numerics::max_abs(terms.speed_equations.mass), numerics::max_abs(terms.constraint_equations.mass));
  for (dynamics::IndependentTerms* equations : {&terms.speed_equations, &terms.constraint_equations}) {
    for (double& value : equations->mass.reshaped()) clear_if_round_off(value, inertia);
    for (MatrixX& form : equations->velocity)
      for (double& value : form.reshaped()) clear_if_round_off(value, inertia * std::max(1.0, 1 / scales.length));
    clear_relative_round_off(equations->viscous);
    clear_relative_round_off(equations->input);
    clear_static_round_off(VectorX::Constant(equations->static_terms.weight.size(), std::max(1.0, scales.length)),
                           scales, equations->static_terms);
  }
}

void clear_round_off(const EquationScales& scales, const std::vector<bool>& is_force,
                     dynamics::EffortBreakdown& breakdown) {
  for (Eigen::Index k = 0; k < breakdown.parts.rows(); ++k) {
    const double unit = is_force[static_cast<std::size_t>(k)] ? scales.length : 1;
    const double size = std::max(scales.gravity_moment / unit, numerics::max_abs(breakdown.parts.row(k)));
    for (double& value : breakdown.parts.row(k)) clear_if_round_off(value, size);
    clear_if_round_off(breakdown.effort[k], size);
  }
}

namespace {

std::vector<bool> flag_lengths(const Mechanism& mechanism, const std::vector<CoordinateId>& coordinates) {
  std::vector<bool> is_length;
  for (const CoordinateId c : coordinates) is_length.push_back(is_length_coordinate(mechanism, c));
  return is_length;
}

constexpr double zero_term_tolerance = 1e-9;  ///< relative to the largest term of its kind: smaller terms count as zero

class EquationsReporter {
 public:
  EquationsReporter(const Mechanism& mechanism, const EquationsQuery& query,
                    const std::vector<conditions::GeometricSymbol>& symbols)
      : mechanism_(mechanism),
        query_(query),
        symbols_(symbols),
        options_{query.independent, Vector3::Zero(), 1},
        terms_(mechanism, options_) {}

  EquationsReport run() {
    list_names();
    set_configuration();
    if (!add_terms() || !add_speeds()) return std::move(out_);
    if (is_requested(EquationSection::torques)) add_effort_breakdown();
    if (is_requested(EquationSection::redundant) && !store(terms_.redundant_terms(at_.q, query_.time), at_.loops))
      return std::move(out_);
    if (is_requested(EquationSection::regressor)) add_regressor();
    if (is_requested(EquationSection::natural)) add_natural();
    if (is_requested(EquationSection::parameters)) add_parameters();
    clear_round_off();
    out_.outcome.status = MotionStatus::done;
    return std::move(out_);
  }

 private:
  bool is_requested(EquationSection section) const { return query_.sections.count(section) > 0; }

  const Coordinate& coordinate(int c) const { return mechanism_.coordinates[static_cast<std::size_t>(c)]; }

  void list_names() {
    for (const int c : terms_.independent()) at_.independent.push_back(coordinate(c).name);
    for (const int c : mechanism_.actuators) at_.actuators.push_back(coordinate(c).name);
    at_.is_length = flag_lengths(mechanism_, terms_.independent());
    at_.is_force = flag_lengths(mechanism_, mechanism_.actuators);
    at_.redundant = terms_.redundant();
    at_.has_rate_constraints = model::has_velocity_constraints(mechanism_);
    at_.closures = terms_.closures();
    at_.disc_rows = terms_.disc_rows();
    at_.notes = terms_.notes();
    at_.torque_scale = scales_.gravity_moment;
  }

  void set_configuration() {
    const std::vector<CoordinateId>& independent = terms_.independent();
    at_.q = dynamics::independent_positions(independent, query_.configuration);
    at_.dq = dynamics::independent_rates(mechanism_, independent, query_.rates);
    at_.ddq = dynamics::independent_rates(mechanism_, independent, query_.accelerations);
  }

  template <class T>
  bool store(Expected<T>&& result, std::optional<T>& target) {
    if (!result) {
      out_.outcome = result.outcome;
      return false;
    }
    target = std::move(result.value);
    return true;
  }

  bool add_terms() {
    if (terms_.degrees_of_freedom() == 0) {
      out_.outcome = {
          MotionStatus::mismatch, 0, "the mechanism has no degrees of freedom: there is no equation of motion", {}};
      return false;
    }
    auto assembled = terms_.assemble(at_.q, query_.configuration);
    if (!assembled) {
      out_.outcome = assembled.outcome;
      return false;
    }
    at_.configuration = assembled.value;
    if (!store(terms_.independent_terms(at_.q, query_.time), at_.terms)) return false;
    find_diagonal_factors();
    return true;
  }

  void clear_round_off() {
    formulas::clear_round_off(scales_, at_.is_length, *at_.terms);
    if (at_.in_speeds) formulas::clear_round_off(scales_, *at_.in_speeds);
    if (at_.loops) formulas::clear_round_off(scales_, terms_.redundant_lengths(), *at_.loops);
    if (at_.split) formulas::clear_round_off(scales_, at_.is_force, *at_.split);
    if (at_.regressor)
      for (MatrixX* matrix : {&at_.regressor->effort, &at_.regressor->shaking_force, &at_.regressor->shaking_moment})
        clear_relative_round_off(*matrix);
    clear_pose_round_off(mechanism_, scales_.length, at_.configuration);
    for (Eigen::Index i = 0; i < at_.q.size(); ++i)
      at_.q[i] = at_.configuration[terms_.independent()[static_cast<std::size_t>(i)]];
  }

  bool add_speeds() {
    const model::SpeedChoice& choice = query_.speeds;
    if (choice.speeds.empty() && choice.constrained.empty()) return true;
    for (const model::GeneralisedSpeed& speed : choice.speeds) at_.speeds.push_back(speed.name);
    for (const model::GeneralisedSpeed& zero : choice.constrained) {
      at_.zero.push_back(zero.name);
      at_.has_constraint_values = at_.has_constraint_values || zero.value;
    }
    return store(terms_.speed_terms(at_.q, choice, query_.time), at_.in_speeds);
  }

  /// u_k = k q̈_k (P1 eq. 27).
  void find_diagonal_factors() {
    const dynamics::IndependentTerms& t = *at_.terms;
    const Eigen::Index d = t.mass.rows();
    if (t.input.rows() != t.input.cols() || !t.input.isApprox(MatrixX::Identity(d, d), zero_term_tolerance)) return;
    const VectorX k = t.mass.diagonal();
    const VectorX size = k.cwiseAbs().cwiseSqrt();
    const auto is_negligible = [&](const MatrixX& matrix) {
      for (Eigen::Index r = 0; r < d; ++r)
        for (Eigen::Index s = 0; s < d; ++s)
          if (std::abs(matrix(r, s)) > zero_term_tolerance * size[r] * size[s]) return false;
      return true;
    };
    MatrixX off_diagonal = t.mass;
    off_diagonal.diagonal().setZero();
    bool decoupled = is_negligible(off_diagonal) && t.viscous.isZero(0);
    for (const MatrixX& form : t.velocity) decoupled = decoupled && is_negligible(form);
    decoupled = decoupled && numerics::max_abs(t.static_terms.sum()) <=
                                 zero_term_tolerance * std::max(at_.torque_scale, numerics::max_coefficient(k));
    if (decoupled) at_.diagonal_factors = k;
  }

  void add_effort_breakdown() {
    auto breakdown = terms_.split_efforts(at_.q, at_.dq, at_.ddq, query_.time);
    if (breakdown)
      at_.split = std::move(breakdown.value);
    else
      at_.notes.push_back("no torques: " + breakdown.outcome.reason);
  }

  void add_regressor() {
    if (has_velocity_constraints(mechanism_)) {
      at_.notes.push_back("no regressor: it does not support constraints on speeds");
      return;
    }
    InverseDynamics inverse_dynamics(mechanism_, options_);
    std::vector<dynamics::CoordinateGuess> guesses;
    for (const CoordinateValue& value : query_.configuration)
      guesses.push_back({coordinate(value.coordinate).name, value.value});
    inverse_dynamics.assemble(at_.q, guesses);
    auto regressor = inverse_dynamics.regressor(at_.q, at_.dq, at_.ddq, query_.time);
    if (regressor)
      at_.regressor = std::move(regressor.value);
    else
      at_.notes.push_back("no regressor: " + regressor.outcome.reason);
  }

  void add_natural() {
    if (mechanism_.space == SpaceKind::spatial)
      at_.notes.push_back("no natural coordinates: they are for planar mechanisms");
    else if (has_velocity_constraints(mechanism_))
      at_.notes.push_back("no natural coordinates: they do not support constraints on speeds");
    else
      at_.natural = verification::natural::compute_natural_terms(mechanism_, at_.configuration);
  }

  void add_parameters() {
    Mechanism configured = mechanism_;
    configured.assembly = query_.configuration;
    Conditions base_parameters = conditions::compute_base_parameters(configured);
    if (base_parameters.status != ConditionsStatus::done) {
      at_.notes.push_back("no base parameters: " + base_parameters.reason);
      return;
    }
    if (!symbols_.empty())
      at_.parameter_names = name_coefficients(configured, base_parameters, symbols_, [&](const Mechanism& other) {
        Mechanism reconfigured = other;
        reconfigured.assembly = query_.configuration;
        return conditions::compute_base_parameters(reconfigured);
      });
    at_.parameters = std::move(base_parameters);
  }

  const Mechanism& mechanism_;
  const EquationsQuery& query_;
  const std::vector<conditions::GeometricSymbol>& symbols_;
  InverseOptions options_;
  dynamics::EquationTerms terms_;
  const EquationScales scales_ = compute_equation_scales(mechanism_);
  EquationsReport out_;
  EquationsAtConfiguration& at_ = out_.at;
};

/// Writes a matrix into a row of numbers, row by row.
template <class Row>
void write_matrix_row(const MatrixX& matrix, Eigen::Index first, Row&& row) {
  const Samples by_rows = matrix;
  row.segment(first, by_rows.size()) = Eigen::Map<const Eigen::RowVectorXd>(by_rows.data(), by_rows.size());
}

/// Allocates N samples; the names of the coordinates must be set.
void size_arrays(Eigen::Index N, Eigen::Index actuators, EquationsAlongRun& out) {
  const auto d = static_cast<Eigen::Index>(out.independent.size()), n = static_cast<Eigen::Index>(out.redundant.size());
  out.mass.resize(N, d * d), out.viscous.resize(N, d * d), out.velocity.resize(N, d * d * d),
      out.static_terms.resize(N, d);
  out.transformation.resize(N, n * d);
  out.discs.resize(N, static_cast<Eigen::Index>(out.disc_rows.size()) * d);
  out.constraints.resize(N, static_cast<Eigen::Index>(out.closures.size()) * n);
  out.parts.resize(N, actuators * static_cast<Eigen::Index>(dynamics::effort_part_names.size()));
}

void write_row(const dynamics::IndependentTerms& terms, const dynamics::RedundantTerms& loops, Eigen::Index k,
               EquationsAlongRun& out) {
  write_matrix_row(terms.mass, 0, out.mass.row(k));
  write_matrix_row(terms.viscous, 0, out.viscous.row(k));
  const Eigen::Index d = terms.mass.rows();
  for (Eigen::Index i = 0; i < d; ++i)
    write_matrix_row(terms.velocity[static_cast<std::size_t>(i)], i * d * d, out.velocity.row(k));
  out.static_terms.row(k) = terms.static_terms.sum();
  write_matrix_row(loops.transformation, 0, out.transformation.row(k));
  write_matrix_row(loops.discs, 0, out.discs.row(k));
  write_matrix_row(loops.constraints, 0, out.constraints.row(k));
  if (loops.rate_offset.size() == 0) return;
  out.rate_offset.conservativeResize(out.transformation.rows(), loops.rate_offset.size());
  out.rate_offset.row(k) = loops.rate_offset;
}

}  // namespace

const std::vector<std::string>& equation_section_names() {
  static const std::vector<std::string> names{"inertia",   "velocity", "gravity",   "torques",
                                              "redundant", "natural",  "regressor", "parameters"};
  return names;
}

EquationsReport compute_equations_at(const Mechanism& mechanism, const EquationsQuery& query,
                                     const std::vector<conditions::GeometricSymbol>& symbols) {
  if (!has_temporary_payloads(mechanism)) return EquationsReporter(mechanism, query, symbols).run();
  const Mechanism current_mechanism = mechanism_at_time(mechanism, query.time);
  EquationsReport report = EquationsReporter(current_mechanism, query, symbols).run();
  for (std::string& note : list_payload_notes(mechanism, query.time)) report.at.notes.push_back(std::move(note));
  return report;
}

EquationsAlongRun as_one_sample(const EquationsAtConfiguration& at) {
  EquationsAlongRun out;
  out.outcome.status = MotionStatus::done;
  out.independent = at.independent;
  out.redundant = at.redundant;
  out.closures = at.closures;
  out.disc_rows = at.disc_rows;
  out.time = VectorX::Zero(1);
  size_arrays(1, static_cast<Eigen::Index>(at.actuators.size()), out);
  write_row(*at.terms, *at.loops, 0, out);
  out.position = at.q.transpose();
  if (at.split)
    write_matrix_row(at.split->parts, 0, out.parts.row(0));
  else
    out.parts.resize(0, 0);
  return out;
}

EquationsAlongRun compute_equations_along(const Mechanism& mechanism, const RunResult& result,
                                          const std::vector<std::string>& independent) {
  EquationsAlongRun out;
  InverseOptions options{independent, Vector3::Zero(), 1};
  const double duration = result.time[result.time.size() - 1] - result.time[0];
  if (duration > 0) options.time_scale = duration;
  const model::PayloadIntervals intervals(mechanism, result.time[result.time.size() - 1]);
  Mechanism present = mechanism_in_interval(mechanism, intervals, 0);
  dynamics::EquationTerms terms(present, options);
  const dynamics::StateTable states = extract_independent_states(terms, result);
  for (const int c : terms.independent())
    out.independent.push_back(mechanism.coordinates[static_cast<std::size_t>(c)].name);
  out.redundant = terms.redundant();
  out.closures = terms.closures();
  out.disc_rows = terms.disc_rows();
  const Eigen::Index N = states.q.rows();
  out.time = result.time;
  out.position = states.q;
  size_arrays(N, result.torque.cols(), out);
  out.outcome = assemble_at_row(terms, result);
  const std::vector<bool> is_length = flag_lengths(mechanism, terms.independent()),
                          is_force = flag_lengths(mechanism, mechanism.actuators),
                          redundant_is_length = terms.redundant_lengths();
  const EquationScales scales = compute_equation_scales(mechanism);
  const bool needs_reassembly =
      has_velocity_constraints(mechanism);  // the independent coordinates do not determine the others
  int interval = 0;
  for (Eigen::Index k = 0; k < N && out.outcome.status == MotionStatus::done; ++k) {
    if (const int next = intervals.index_at(result.time[k]); next != interval) {  // a payload comes or goes
      interval = next;
      present = mechanism_in_interval(mechanism, intervals, interval);
      terms = dynamics::EquationTerms(present, options);
      out.outcome = assemble_at_row(terms, result, k);
    } else if (needs_reassembly) {
      out.outcome = assemble_at_row(terms, result, k);
    }
    if (out.outcome.status != MotionStatus::done) break;
    auto equations = terms.independent_terms(states.q.row(k), result.time[k]);
    auto redundant_terms = terms.redundant_terms(states.q.row(k), result.time[k]);
    auto breakdown = terms.split_efforts(states.q.row(k), states.dq.row(k), states.ddq.row(k), result.time[k]);
    out.outcome = !equations ? equations.outcome : !redundant_terms ? redundant_terms.outcome : breakdown.outcome;
    if (out.outcome.status != MotionStatus::done) break;
    clear_round_off(scales, is_length, equations.value);
    clear_round_off(scales, redundant_is_length, redundant_terms.value);
    clear_round_off(scales, is_force, breakdown.value);
    write_row(equations.value, redundant_terms.value, k, out);
    write_matrix_row(breakdown.value.parts, 0, out.parts.row(k));
  }
  return out;
}

}  // namespace balance::formulas
