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

/// Relative increase of a figure that is round-off of the motion and the figure, and one that a vanishing number may
/// cost.
constexpr double figure_tie_tolerance = 1e-10, round_off_tie_tolerance = 1e-9;
/// Relative changes of the added mass below this are round-off, or not worth an exchange.
constexpr double mass_tie_tolerance = 1e-12, mass_saving_tolerance = 1e-9;
/// Residual of the conditions that is round-off of their evaluation.
constexpr double residual_round_off = 1e-12;
/// Distances in unit coordinates at which a number is tentatively moved onto its bound, and at which it is an error of
/// the search.
constexpr double bound_distance = 1e-7, round_off_distance = 2e-9;
/// Part of an amount by which it is tentatively lowered, and number of bisections towards its smallest value.
constexpr double first_reduction = 1e-4;
constexpr int reduction_bisections = 30;
constexpr int max_descents = 4, max_tie_cuts = 20, max_tie_steps = 60;
/// Steps along a set of equal designs, in unit coordinates.
constexpr double max_tie_radius = 2, min_tie_radius = 1e-5;
constexpr int max_tie_restorations = 30, max_limit_restorations = 8;

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
    const VectorX& settled = context.problem.settled_values;
    settled_ = settled.size() == u_.size() ? context.scaling.to_unit(settled) : context.scaling.start();
    value_ = objective_(u_, nullptr);
    value_round_off_ = objective_.round_off();  // a figure that vanishes stays zero up to the round-off of its terms
    residual_ = std::max(max_residual(u_, conditions_), residual_round_off);
    added_mass_ = added_mass(u_);
  }

  VectorX run() {
    if (!std::isfinite(value_)) return u_;
    settle_single_numbers();
    for (int k = 0; k < max_descents && !context_.budget.is_spent(); ++k) {
      if (!lower_mass_along_ties()) break;
      settle_single_numbers();
    }
    return u_;
  }

 private:
  /// Marks the numbers that scale an element: its mass, its moment of inertia or a spring's stiffness.
  void find_amounts(const Mechanism& mechanism) {
    const std::vector<dynamics::Parameter> parameters =
        dynamics::list_parameters(mechanism, context_.classification.loose_springs);
    const VectorX added = added_parameter_mask(mechanism, parameters);
    is_amount_.assign(static_cast<std::size_t>(context_.scaling.size()), false);
    for (int i = 0; i < context_.scaling.size(); ++i) {
      bool scales = false, turns = false, moves = false;
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const auto k = static_cast<int>(p);
        if (!context_.classification.has_effect(i, k)) continue;
        const bool is_added = added[k] != 0;
        scales = scales || (parameters[p].kind == dynamics::ParameterKind::stiffness) ||
                 (is_added && parameters[p].kind == dynamics::ParameterKind::mass);
        turns = turns || (is_added && parameters[p].kind == dynamics::ParameterKind::moment_of_inertia);
        moves = moves || parameters[p].kind == dynamics::ParameterKind::first_moment || !is_added;
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
    const VectorX values = conditions::term_values(context_.mechanism(u), context_.options.loose_springs);
    if (values.size() != conditions.matrix.cols()) return std::numeric_limits<double>::infinity();
    return numerics::max_abs(scaled_residuals(conditions, values));
  }

  /// Whether figure, conditions and limits are those of the design, or better.
  bool is_as_good(const VectorX& u, bool changes_geometry, double tolerance = figure_tie_tolerance) const {
    try {
      const double value = objective_(u, nullptr);
      const double allowance = std::max(tolerance * std::abs(value_), value_round_off_);
      if (!(value <= value_ + allowance) || !context_.is_admissible(u)) return false;
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
    return context_.scaling.to_unit(i, value);
  }

  bool is_amount(int i) const { return is_amount_[static_cast<std::size_t>(i)]; }
  bool is_geometric(int i) const { return context_.classification.is_geometric[static_cast<std::size_t>(i)]; }

  bool try_value(int i, double target) {
    if (u_[i] == target) return true;
    VectorX moved = u_;
    moved[i] = target;
    const double mass = added_mass(moved);
    if (!(mass <= added_mass_ + mass_tie_tolerance * std::abs(added_mass_))) return false;
    const bool is_round_off = std::abs(u_[i] - target) < round_off_distance;
    if (!is_as_good(moved, is_geometric(i), is_round_off ? round_off_tie_tolerance : figure_tie_tolerance))
      return is_round_off && !is_geometric(i) && remove_round_off(moved, i);
    u_ = std::move(moved);
    added_mass_ = mass;
    if (is_round_off) value_ = std::max(value_, objective_(u_, nullptr));  // what is compared with from now on
    return true;
  }

  /// Lets the other numbers make up for a number that has lost the error of a search.
  bool remove_round_off(const VectorX& moved, int i) {
    std::vector<int> others = exchangeable_numbers();
    std::erase_if(others, [&](int k) { return k == i || std::abs(moved[k]) == 1; });
    const std::optional<FigureFace> face = FigureFace::make(context_, u_);
    const VectorX restored = solve_tie_equations(face ? &*face : nullptr, others, moved, context_.limits->size() > 0);
    const double mass = added_mass(restored);
    const bool is_lighter = mass <= added_mass_ + round_off_tie_tolerance * std::abs(added_mass_);
    if (!is_lighter || !is_as_good(restored, false, round_off_tie_tolerance)) return false;
    u_ = restored;
    added_mass_ = mass;
    value_ = std::max(value_, objective_(u_, nullptr));
    return true;
  }

  /// Elements vanish if they may, or become as small as they may; other numbers return to their start values, and those
  /// next to a bound lie on it.
  void settle_single_numbers() {
    for (int i = 0; i < context_.scaling.size() && !context_.budget.is_spent(); ++i)
      if (is_amount(i)) try_value(i, coordinate_of(i, 0));
    for (int i = 0; i < context_.scaling.size() && !context_.budget.is_spent(); ++i)
      if (is_amount(i) && u_[i] != coordinate_of(i, 0)) reduce_amount(i);
    for (int i = 0; i < context_.scaling.size() && !context_.budget.is_spent(); ++i) {
      const bool has_settled = is_amount(i) && u_[i] == coordinate_of(i, 0);
      if (has_settled || try_value(i, settled_[i])) continue;
      for (const double bound : {-1.0, 1.0})
        if (std::abs(u_[i] - bound) < bound_distance) try_value(i, bound);
    }
  }

  /// Moves an amount as close to zero as figure, conditions and limits allow.
  void reduce_amount(int i) {
    const double from = u_[i], zero = coordinate_of(i, 0);
    if (!context_.problem.variables[static_cast<std::size_t>(i)].discrete_values.empty()) return;
    VectorX without = u_;
    without[i] = zero;
    if (!(added_mass(without) < added_mass_)) return;  // of springs, the start value is preferred to a weaker one
    if (!try_value(i, from + first_reduction * (zero - from))) return;
    double kept = first_reduction, lost = 1;
    for (int k = 0; k < reduction_bisections && lost - kept > mass_saving_tolerance; ++k) {
      const double middle = (kept + lost) / 2;
      (try_value(i, from + middle * (zero - from)) ? kept : lost) = middle;
    }
  }

  /// Continuous numbers that change masses, but not the geometry.
  std::vector<int> exchangeable_numbers() const {
    std::vector<int> numbers;
    for (int i = 0; i < context_.scaling.size(); ++i)
      if (!is_geometric(i) && context_.scaling.half_width()[i] > 0 &&
          context_.problem.variables[static_cast<std::size_t>(i)].discrete_values.empty())
        numbers.push_back(i);
    return numbers;
  }

  /// Those of the numbers that leave the figure as it is wherever they are.
  std::vector<int> select_ineffective(const std::vector<int>& numbers) const {
    std::vector<int> ineffective;
    for (const int i : numbers) {
      const auto is_value_kept = [&](double target) {
        VectorX moved = u_;
        moved[i] = target;
        return std::abs(objective_(moved, nullptr) - value_) <= std::max(1e-13 * std::abs(value_), value_round_off_);
      };
      if (!context_.budget.is_spent() && is_value_kept(u_[i] > 0 ? -0.83 : 0.83) && is_value_kept(u_[i] / 2 + 0.07))
        ineffective.push_back(i);
    }
    return ineffective;
  }

  int element_count(const VectorX& u) const {
    int count = 0;
    for (int i = 0; i < context_.scaling.size(); ++i)
      if (is_amount(i) && u[i] != coordinate_of(i, 0)) ++count;
    return count;
  }

  /// The limits at u_, g ≥ 0, and their derivatives.
  struct LinearLimits {
    VectorX g;
    MatrixX slopes;
  };

  /// Shifts mass between elements that can replace each other, and moves elements to places where less mass does the
  /// same. The steps are linear programs over the directions in which neither the figure nor a condition changes, with
  /// tangents of the peaks and limits that a step would exceed. Where masses are multiplied by places, the equal designs
  /// form a curved set, to which every step is brought back.
  /// @return whether mass or elements were saved
  bool lower_mass_along_ties() {
    std::vector<int> numbers = exchangeable_numbers();
    const std::optional<FigureFace> face = FigureFace::make(context_, u_);
    const FigureFace* figure = face ? &*face : nullptr;
    const bool is_ineffective = figure == nullptr && objective_.is_simulated();
    if (is_ineffective) numbers = select_ineffective(numbers);
    bool has_saved = false, has_moved = true;
    MatrixX basis;
    LinearLimits limits;
    double radius = max_tie_radius;
    for (int k = 0; k < max_tie_steps && radius > min_tie_radius && !context_.budget.is_spent(); ++k) {
      if (has_moved) {
        basis = find_flat_mass_directions(context_, is_ineffective ? nullptr : &objective_, figure, conditions_, u_,
                                          numbers);
        if (basis.cols() == 0) break;
        limits = {};
        if (context_.limits->size() > 0) context_.limits->evaluate(u_, limits.g, &limits.slopes);
      }
      numerics::LinearProgram program = make_program(basis, numbers, limits, radius);
      const std::optional<VectorX> lighter = find_lighter(figure, numbers, basis, program);
      has_moved = lighter.has_value();
      if (!lighter) {
        if (!has_saving_) break;
        radius /= 4;
        continue;
      }
      u_ = *lighter;
      added_mass_ = added_mass(u_);
      has_saved = true;
      radius = std::min(max_tie_radius, 2 * radius);
    }
    return has_saved;
  }

  /// Solves the program, adding tangents of what its solution would exceed. Sets has_saving_.
  std::optional<VectorX> find_lighter(const FigureFace* figure, const std::vector<int>& numbers, const MatrixX& basis,
                                      numerics::LinearProgram& program) {
    for (int k = 0; k < max_tie_cuts; ++k) {
      const numerics::LinearProgramSolution solution = solve_linear_program(program);
      if (k == 0) has_saving_ = false;
      if (solution.status != numerics::LinearProgramStatus::optimal) return std::nullopt;
      const VectorX step = move_by(basis * solution.x);
      if (k == 0)
        has_saving_ = program.cost.dot(solution.x) < -mass_saving_tolerance * std::abs(added_mass_) || saves_mass(step);
      if (!has_saving_) return std::nullopt;
      const VectorX trial = restore(figure, numbers, step);
      if (!saves_mass(trial)) return std::nullopt;
      if (is_as_good(trial, false)) return trial;
      const bool has_figure_cuts = figure != nullptr && figure->add_cuts(step, u_, basis, program);
      if (!add_limit_cuts(step, basis, program) && !has_figure_cuts) return std::nullopt;
    }
    return std::nullopt;
  }

  /// @param radius of each number's change
  numerics::LinearProgram make_program(const MatrixX& basis, const std::vector<int>& numbers,
                                       const LinearLimits& limits, double radius) const {
    VectorX features;
    MatrixX slopes;
    context_.features.evaluate(u_, features, &slopes);
    numerics::LinearProgram program(basis.cols());
    const VectorX mass_slope = slopes.topRows(mass_coefficients_.size()).transpose() * mass_coefficients_;
    program.cost = basis.transpose() * mass_slope;
    for (const int i : numbers)
      if (basis.row(i).norm() > 1e-12)
        program.add_row(std::max(-1 - u_[i], -radius), basis.row(i).transpose(), std::min(1 - u_[i], radius));
    VectorX g;
    MatrixX normals;
    context_.physical_constraints.evaluate(features, &slopes, g, &normals);
    add_tangents(program, g, normals * basis);
    add_tangents(program, limits.g, limits.slopes.rows() > 0 ? MatrixX(limits.slopes * basis) : MatrixX());
    return program;
  }

  static void add_tangents(numerics::LinearProgram& program, const VectorX& g, const MatrixX& slopes) {
    for (Eigen::Index k = 0; k < g.size(); ++k)
      if (std::isfinite(g[k]) && slopes.row(k).allFinite())
        program.add_row(-std::max(0.0, g[k]), slopes.row(k).transpose(), numerics::no_bound);
  }

  bool add_limit_cuts(const VectorX& trial, const MatrixX& basis, numerics::LinearProgram& program) const {
    if (context_.limits->size() == 0) return false;
    VectorX g;
    MatrixX slopes;
    context_.limits->evaluate(trial, g, &slopes);
    bool has_cuts = false;
    for (Eigen::Index k = 0; k < g.size(); ++k) {
      if (!(g[k] < 0) || !slopes.row(k).allFinite()) continue;
      program.add_row(slopes.row(k).dot(trial - u_) - g[k], (slopes.row(k) * basis).transpose(), numerics::no_bound);
      has_cuts = true;
    }
    return has_cuts;
  }

  VectorX move_by(const VectorX& step) const {
    VectorX moved = clip_to_unit_box(u_ + step);
    for (Eigen::Index i = 0; i < moved.size(); ++i)
      for (const double bound : {-1.0, 1.0})
        if (step[i] != 0 && std::abs(moved[i] - bound) < bound_distance) moved[i] = bound;
    return moved;
  }

  bool saves_mass(const VectorX& moved) const {
    const double mass = added_mass(moved), size = std::abs(added_mass_);
    return mass < added_mass_ - mass_saving_tolerance * size ||
           (mass <= added_mass_ + mass_tie_tolerance * size && element_count(moved) < element_count(u_));
  }

  /// The nearest design with the same conditions and figures, within the limits. Numbers on their bounds stay there if
  /// that is possible.
  VectorX restore(const FigureFace* figure, const std::vector<int>& numbers, const VectorX& from) const {
    std::vector<int> inner;
    for (const int i : numbers)
      if (std::abs(from[i]) < 1) inner.push_back(i);
    for (const std::vector<int>& moving : {inner, numbers}) {
      VectorX u = solve_tie_equations(figure, moving, from, false);
      if (context_.limits->size() > 0 && !context_.limits->is_satisfied(u))
        u = solve_tie_equations(figure, moving, u, true);
      if (saves_mass(u) && is_as_good(u, false)) return u;
    }
    return solve_tie_equations(figure, numbers, from, false);
  }

  VectorX solve_tie_equations(const FigureFace* figure, const std::vector<int>& numbers, const VectorX& from,
                              bool with_limits) const {
    if (numbers.empty()) return from;
    const ConditionResidual conditions(context_, conditions_);
    numerics::NonlinearSystem equations;
    equations.evaluate = [&](const VectorX& u, VectorX& values, MatrixX* jacobian) {
      VectorX features;
      MatrixX slopes;
      context_.features.evaluate(u, features, jacobian != nullptr ? &slopes : nullptr);
      std::vector<VectorX> blocks(1);
      std::vector<MatrixX> by_block(1);
      conditions.evaluate(u, blocks[0], jacobian != nullptr ? &by_block[0] : nullptr);
      const auto add = [&](VectorX block, MatrixX block_slopes) {
        blocks.push_back(std::move(block));
        by_block.push_back(std::move(block_slopes));
      };
      if (figure != nullptr) {
        const MatrixX& rows = figure->constant_parameter_rows();
        add(rows * (features - figure->parameters()).head(rows.cols()),
            jacobian != nullptr ? MatrixX(rows * slopes.topRows(rows.cols())) : MatrixX());
        VectorX excess;
        MatrixX by_excess;
        figure->evaluate_excess(features, &slopes, excess, jacobian != nullptr ? &by_excess : nullptr);
        add(excess, by_excess);
      }
      if (with_limits) {
        VectorX g;
        MatrixX by_limit;
        context_.limits->evaluate(u, g, jacobian != nullptr ? &by_limit : nullptr);
        for (Eigen::Index k = 0; k < g.size(); ++k)
          if (g[k] >= 0) {
            g[k] = 0;
            if (jacobian != nullptr) by_limit.row(k).setZero();
          }
        add(g, by_limit);
      }
      Eigen::Index count = 0;
      for (const VectorX& block : blocks) count += block.size();
      values.resize(count);
      if (jacobian != nullptr) jacobian->resize(count, u.size());
      Eigen::Index row = 0;
      for (std::size_t k = 0; k < blocks.size(); row += blocks[k].size(), ++k) {
        values.segment(row, blocks[k].size()) = blocks[k];
        if (jacobian != nullptr && blocks[k].size() > 0) jacobian->middleRows(row, blocks[k].size()) = by_block[k];
      }
      return values.allFinite();
    };
    VectorX values;
    if (!equations.evaluate(from, values, nullptr)) return from;
    equations.primary_rows = equations.row_count = static_cast<int>(values.size());
    VectorX restored = from;
    restored(numbers) =
        solve_levenberg_marquardt(restrict_to_variables(equations, numbers, from), VectorX(from(numbers)),
                                  with_limits ? max_limit_restorations : max_tie_restorations)
            .u;
    return restored;
  }

  const SolverContext& context_;
  const ScaledObjective& objective_;
  const Conditions& conditions_;
  VectorX u_, mass_coefficients_;
  VectorX settled_;  ///< where numbers without effect return to
  std::vector<bool> is_amount_;
  bool has_saving_ = false;  ///< whether the last program promised any
  double value_ = 0, value_round_off_ = 0, residual_ = 0, added_mass_ = 0;
};

}  // namespace

VectorX break_ties(const SolverContext& context, const ScaledObjective& objective, const Conditions& conditions,
                   const VectorX& u) {
  return TieBreaker(context, objective, conditions, u).run();
}

}  // namespace balance::design
