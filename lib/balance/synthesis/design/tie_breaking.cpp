#include "balance/synthesis/design/tie_breaking.hpp"

#include "balance/foundation/base/error.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/foundation/numerics/linear_program.hpp"
#include "balance/synthesis/design/condition_equations.hpp"
#include "balance/synthesis/design/objective_builder.hpp"
#include "balance/synthesis/design/solution_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace balance::design {

namespace {

/// Relative increase of a figure that is round-off of the motion and the figure.
constexpr double figure_tie_tolerance = 1e-10;
/// Relative changes of the added mass below this are round-off, or not worth an exchange.
constexpr double mass_tie_tolerance = 1e-12, mass_saving_tolerance = 1e-9;
/// Residual of the conditions that is round-off of their evaluation.
constexpr double residual_round_off = 1e-12;
/// Distance in unit coordinates at which a number is tentatively moved onto its bound.
constexpr double bound_distance = 1e-7;
constexpr int max_exchanges = 4, max_exchange_rounds = 20, max_tie_steps = 60;
/// Steps along a curved set of equal designs, in unit coordinates.
constexpr double first_tie_radius = 0.2, min_tie_radius = 1e-3;

class TieBreaker {
 public:
  TieBreaker(const SolverContext& context, const ScaledObjective& objective, const Conditions& conditions, VectorX u)
      : context_(context),
        objective_(objective),
        conditions_(conditions),
        u_(std::move(u)),
        mass_coefficients_(size_coefficients(ObjectiveTerm::Size::added_mass, context.classification.base_mechanism,
                                             context.classification.loose_springs)) {
    find_amounts(context.classification.base_mechanism);
    value_ = objective_(u_, nullptr);
    // A figure that vanishes stays zero up to the round-off of its terms.
    value_tolerance_ = std::max(figure_tie_tolerance * std::abs(value_), objective_.round_off());
    residual_ = std::max(max_residual(u_, conditions_), residual_round_off);
    added_mass_ = added_mass(u_);
  }

  VectorX run() {
    if (!std::isfinite(value_)) return u_;
    move_single_numbers();
    for (int k = 0; k < max_exchanges && !context_.budget.is_spent(); ++k)
      if (!exchange_masses()) break;
    return u_;
  }

 private:
  /// Marks the numbers that scale an element: its mass, its moment of inertia or a spring's stiffness.
  void find_amounts(const Mechanism& mechanism) {
    const std::vector<Parameter> parameters = list_parameters(mechanism, context_.classification.loose_springs);
    const VectorX added = added_parameter_mask(mechanism, parameters);
    is_amount_.assign(static_cast<std::size_t>(context_.scaling.size()), false);
    for (int i = 0; i < context_.scaling.size(); ++i) {
      bool scales = false, turns = false, moves = false;
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const auto k = static_cast<int>(p);
        if (!context_.classification.has_effect(i, k)) continue;
        const bool is_added = added[k] != 0;
        scales = scales || (parameters[p].kind == ParameterKind::stiffness) ||
                 (is_added && parameters[p].kind == ParameterKind::mass);
        turns = turns || (is_added && parameters[p].kind == ParameterKind::moment_of_inertia);
        moves = moves || parameters[p].kind == ParameterKind::first_moment || !is_added;
      }
      is_amount_[static_cast<std::size_t>(i)] = scales || (turns && !moves);
    }
  }

  double added_mass(const VectorX& u) const {
    VectorX features;
    context_.features.evaluate(u, features, nullptr);
    return mass_coefficients_.dot(features.head(mass_coefficients_.size()));
  }

  double max_residual(const VectorX& u, const Conditions& conditions) const {
    if (conditions.matrix.rows() == 0) return 0;
    const VectorX values = term_values(context_.mechanism(u), context_.options.loose_springs);
    if (values.size() != conditions.matrix.cols()) return std::numeric_limits<double>::infinity();
    return max_abs(scaled_residuals(conditions, values));
  }

  /// Whether figure, conditions and limits are those of the design, or better.
  bool is_as_good(const VectorX& u, bool changes_geometry) const {
    try {
      const double value = objective_(u, nullptr);
      if (!(value <= value_ + value_tolerance_) || !context_.is_admissible(u)) return false;
      if (!changes_geometry) return max_residual(u, conditions_) <= residual_;
      if (!context_.infeasibility_reason(u).empty()) return false;
      if (context_.problem.goals.empty()) return true;
      const Conditions conditions = context_.conditions_at(u);
      return conditions.status == ConditionsStatus::done && max_residual(u, conditions) <= residual_;
    } catch (const SpecError&) {
      return false;  // an expression of the spec has no value here
    } catch (const std::invalid_argument&) {
      return false;  // there is no motion
    }
  }

  /// Unit coordinate of a value, which is the nearest size if there are sizes.
  double coordinate_of(int i, double value) const {
    const DesignVariable& variable = context_.problem.variables[static_cast<std::size_t>(i)];
    value = std::clamp(value, variable.lower, variable.upper);
    if (!variable.discrete_values.empty())
      value = *std::min_element(variable.discrete_values.begin(), variable.discrete_values.end(),
                                [value](double a, double b) { return std::abs(a - value) < std::abs(b - value); });
    if (value == variable.start) return context_.scaling.start()[i];
    const double half = context_.scaling.half_width()[i];
    return half > 0 ? std::clamp((value - context_.scaling.centre()[i]) / half, -1.0, 1.0) : u_[i];
  }

  bool try_value(int i, double target) {
    if (u_[i] == target) return true;
    VectorX moved = u_;
    moved[i] = target;
    const double mass = added_mass(moved);
    if (!(mass <= added_mass_ + mass_tie_tolerance * std::abs(added_mass_))) return false;
    if (!is_as_good(moved, context_.classification.is_geometric[static_cast<std::size_t>(i)])) return false;
    u_ = std::move(moved);
    added_mass_ = mass;
    return true;
  }

  /// Elements vanish if they may; other numbers return to their start values.
  void move_single_numbers() {
    for (int i = 0; i < context_.scaling.size() && !context_.budget.is_spent(); ++i)
      if (is_amount_[static_cast<std::size_t>(i)]) try_value(i, coordinate_of(i, 0));
    for (int i = 0; i < context_.scaling.size() && !context_.budget.is_spent(); ++i)
      if (!is_amount_[static_cast<std::size_t>(i)] || u_[i] != coordinate_of(i, 0))
        try_value(i, context_.scaling.start()[i]);
  }

  /// Continuous numbers that change masses, but not the geometry.
  std::vector<int> exchangeable_numbers() const {
    std::vector<int> numbers;
    for (int i = 0; i < context_.scaling.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!context_.classification.is_geometric[k] && context_.scaling.half_width()[i] > 0 &&
          context_.problem.variables[k].discrete_values.empty())
        numbers.push_back(i);
    }
    return numbers;
  }

  int element_count(const VectorX& u) const {
    int count = 0;
    for (int i = 0; i < context_.scaling.size(); ++i)
      if (is_amount_[static_cast<std::size_t>(i)] && u[i] != coordinate_of(i, 0)) ++count;
    return count;
  }

  /// Shifts mass between elements that can replace each other: a linear program over the directions in which neither
  /// the figure nor a condition changes, with tangents of the peaks and limits that a step would exceed.
  /// @return whether mass or elements were saved
  bool exchange_masses() {
    const std::vector<int> numbers = exchangeable_numbers();
    if (numbers.size() < 2) return false;
    const MatrixX basis = find_flat_mass_directions(context_, objective_, conditions_, u_, numbers);
    if (basis.cols() == 0) return false;
    const std::optional<FigureFace> face = FigureFace::make(context_, u_);
    LinearProgram program = make_program(basis, numbers);
    for (int k = 0; k < max_exchange_rounds; ++k) {
      const LinearProgramSolution solution = solve_linear_program(program);
      if (solution.status != LinearProgramStatus::optimal) return false;
      const VectorX step = basis * solution.x, trial = move_by(step);
      if (!saves_mass(trial)) return false;
      if (is_as_good(trial, false)) return accept(trial);
      const bool has_figure_cuts = face && face->add_cuts(trial, basis, program);
      if (!add_limit_cuts(trial, basis, program) && !has_figure_cuts) break;
    }
    return face && follow_ties(*face, numbers);
  }

  /// @param radius of each number's change
  LinearProgram make_program(const MatrixX& basis, const std::vector<int>& numbers, double radius = 2) const {
    VectorX features;
    MatrixX slopes;
    context_.features.evaluate(u_, features, &slopes);
    LinearProgram program(basis.cols());
    const VectorX mass_slope = slopes.topRows(mass_coefficients_.size()).transpose() * mass_coefficients_;
    program.cost = basis.transpose() * mass_slope;
    for (const int i : numbers)
      if (basis.row(i).norm() > 1e-12)
        program.add_row(std::max(-1 - u_[i], -radius), basis.row(i).transpose(), std::min(1 - u_[i], radius));
    VectorX g;
    MatrixX normals;
    context_.physical_constraints.evaluate(features, &slopes, g, &normals);
    for (Eigen::Index k = 0; k < g.size(); ++k)
      program.add_row(-std::max(0.0, g[k]), (normals.row(k) * basis).transpose(), no_bound);
    return program;
  }

  bool add_limit_cuts(const VectorX& trial, const MatrixX& basis, LinearProgram& program) const {
    if (context_.limits->size() == 0) return false;
    VectorX g;
    MatrixX slopes;
    context_.limits->evaluate(trial, g, &slopes);
    bool has_cuts = false;
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (!(g[k] < 0) || !slopes.row(k).allFinite()) continue;
      program.add_row(slopes.row(k).dot(trial - u_) - g[k], (slopes.row(k) * basis).transpose(), no_bound);
      has_cuts = true;
    }
    return has_cuts;
  }

  VectorX move_by(const VectorX& step) const {
    VectorX moved = clip_to_unit_box(u_ + step);
    for (Eigen::Index i = 0; i < moved.size(); ++i)
      for (const double bound : {-1.0, 1.0})
        if (std::abs(step[i]) > bound_distance && std::abs(moved[i] - bound) < bound_distance) moved[i] = bound;
    return moved;
  }

  bool saves_mass(const VectorX& moved) const {
    const double mass = added_mass(moved), size = std::abs(added_mass_);
    return mass < added_mass_ - mass_saving_tolerance * size ||
           (mass <= added_mass_ + mass_tie_tolerance * size && element_count(moved) < element_count(u_));
  }

  bool accept(const VectorX& moved) {
    u_ = moved;
    added_mass_ = added_mass(moved);
    move_single_numbers();
    return true;
  }

  /// The same if masses are multiplied by places, so that the designs that are as good form a curved set: small steps of
  /// the linear program, each brought back onto the set.
  bool follow_ties(const FigureFace& face, const std::vector<int>& numbers) {
    bool has_saved = false;
    double radius = first_tie_radius;
    for (int k = 0; k < max_tie_steps && radius > min_tie_radius && !context_.budget.is_spent(); ++k) {
      const MatrixX basis = find_flat_mass_directions(context_, objective_, conditions_, u_, numbers);
      if (basis.cols() == 0) break;
      const LinearProgramSolution solution = solve_linear_program(make_program(basis, numbers, radius));
      if (solution.status != LinearProgramStatus::optimal) break;
      const VectorX trial = restore(face, numbers, move_by(basis * solution.x));
      if (saves_mass(trial) && is_as_good(trial, false)) {
        u_ = trial;
        added_mass_ = added_mass(trial);
        has_saved = true;
        radius *= 1.5;
      } else {
        radius /= 3;
      }
    }
    if (has_saved) move_single_numbers();
    return has_saved;
  }

  /// The nearest design with the same conditions and figures.
  VectorX restore(const FigureFace& face, const std::vector<int>& numbers, const VectorX& from) const {
    const ConditionResidual conditions(context_, conditions_);
    const MatrixX figures = face.constant_parameter_rows();
    VectorX u = from;
    NonlinearSystem equations;
    equations.primary_rows = equations.row_count = conditions.size() + static_cast<int>(figures.rows());
    equations.evaluate = [&](const VectorX& v, VectorX& values, MatrixX* jacobian) {
      u(numbers) = v;
      VectorX residual, features;
      MatrixX residual_slopes, slopes;
      conditions.evaluate(u, residual, jacobian != nullptr ? &residual_slopes : nullptr);
      context_.features.evaluate(u, features, jacobian != nullptr ? &slopes : nullptr);
      values.resize(equations.row_count);
      values.head(residual.size()) = residual;
      values.tail(figures.rows()) = figures * (features - face.parameters()).head(figures.cols());
      if (jacobian != nullptr) {
        MatrixX all(equations.row_count, u.size());
        if (residual.size() > 0) all.topRows(residual.size()) = residual_slopes;
        all.bottomRows(figures.rows()) = figures * slopes.topRows(figures.cols());
        *jacobian = all(Eigen::all, numbers);
      }
      return values.allFinite();
    };
    u(numbers) = solve_levenberg_marquardt(equations, VectorX(from(numbers)), 30).u;
    return u;
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  const Conditions& conditions_;
  VectorX u_, mass_coefficients_;
  std::vector<bool> is_amount_;
  double value_ = 0, value_tolerance_ = 0, residual_ = 0, added_mass_ = 0;
};

}  // namespace

VectorX break_ties(const SolverContext& context, const ScaledObjective& objective, const Conditions& conditions,
                   const VectorX& u) {
  return TieBreaker(context, objective, conditions, u).run();
}

}  // namespace balance::design
