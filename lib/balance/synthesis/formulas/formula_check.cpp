#include "balance/synthesis/formulas/formula_check.hpp"

#include "balance/foundation/base/elementary.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/equation_terms.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"
#include "balance/synthesis/formulas/closed_poses.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"
#include "balance/synthesis/formulas/formula_sheet.hpp"
#include "balance/synthesis/formulas/parameter_sampler.hpp"
#include "balance/synthesis/formulas/solved_conditions.hpp"
#include "balance/synthesis/verification/natural_points.hpp"
#include "balance/synthesis/verification/natural_terms.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>

namespace balance::formulas {

// Compares formulas in natural coordinates with the second formulation.

/// Compares the printed mass matrix and C_P with those of the second formulation, evaluates the constraints at its
/// points, where they must vanish, and compares their Jacobian with finite differences, which are exact for quadratic
/// functions.
/// @param names values of all names there; those of the points are filled in
/// @param coordinates of all joints, with the loops closed
/// @return the maximum error, relative to quantities of the same kind
double max_natural_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                         const Mechanism& mechanism, std::map<std::string, double> names, const VectorX& coordinates);

// Compares a printed regressor with the engine's.

/// One state, of the tree and of the engine.
struct RegressorState {
  std::vector<double> y;  ///< per column, with the loops closed
  VectorX dy, ddy;        ///< per column
  MatrixX B;  ///< rates of the columns per rate of the engine's independent coordinates, all of which are actuated
  VectorX q, rate, acceleration;  ///< the engine's state
};

/// @param texts by label, as printed; missing labels stand for the sheet's polynomials
/// @return the maximum difference between BᵀY and the engine's regressor, relative to the terms; NaN if the engine has
/// none
double max_regressor_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                           InverseDynamics& engine, const RegressorState& state);

namespace {

/// Round-off of thousands of terms is far below this, a wrong term far above.
constexpr double check_tolerance = 1e-9;
constexpr int max_pose_attempts = 60, attempts_per_offset = 15;
/// Number of states with other numbers, and of poses tried with each draw of these.
constexpr int perturbed_state_count = 2, max_perturbed_pose_attempts = 6;
/// Redundant closures depend on the others only up to the round-off of the pose.
constexpr double redundancy_threshold = 1e-7;
constexpr double min_pose_regularity = 1e-2, closure_consistency_tolerance = 1e-10;
/// Of the coordinates from those of another assembly [rad or m].
constexpr double max_assembly_difference = 1e-6;

/// Zero if both are, as without mass.
double relative_error(double difference, double scale) {
  return std::abs(difference) / std::max(scale, std::numeric_limits<double>::min());
}

class EngineComparison {
 public:
  EngineComparison(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                   const Mechanism& mechanism, std::uint64_t seed)
      : sheet_(sheet),
        texts_(texts),
        mechanism_(remove_unmodelled(sheet, mechanism)),
        engine_(mechanism_, engine_options(sheet, mechanism)),
        length_(characteristic_length(mechanism_)),
        random_(seed),
        n_(static_cast<Eigen::Index>(sheet.equations.M.size())) {}

  /// Adds the error at one random state to the maximum.
  /// @return false if no pose was found from this random start
  bool compare(double& error) {
    VectorX y(n_);
    VectorX q;
    if (!find_pose(y) || !engine_pose(y, q)) return false;
    const MatrixX A = jacobian(y), S = selection();
    MatrixX stacked_jacobian(A.rows() + S.rows(), n_);
    stacked_jacobian << A, S;
    numerics::ColumnPivotingQr solver;
    solver.setThreshold(redundancy_threshold);
    solver.compute(stacked_jacobian);
    if (solver.rank() < n_ || has_small_pivot(y)) return false;
    // near a singular pose, round-off is too large to judge formulas
    if (regularity(stacked_jacobian) < min_regularity()) return false;
    MatrixX rhs = MatrixX::Zero(stacked_jacobian.rows(), S.rows());
    rhs.bottomRows(S.rows()).setIdentity();
    const MatrixX B = solver.solve(rhs);
    const VectorX v = random_vector(S.rows(), 1), a = random_vector(S.rows(), 1), dy = B * v;
    VectorX bias_rhs = VectorX::Zero(stacked_jacobian.rows());
    bias_rhs.head(A.rows()) = -quadratic(y, dy);
    const VectorX gamma = solver.solve(bias_rhs);
    // at an inexact pose, redundant closures contradict the others
    if (numerics::max_abs(stacked_jacobian * B - rhs) > closure_consistency_tolerance ||
        numerics::max_abs(stacked_jacobian * gamma - bias_rhs) > closure_consistency_tolerance)
      return false;
    const auto M = engine_.mass_matrix(q);
    const auto h = engine_.bias(q, v);
    if (!M || !h) return false;
    const auto terms = tree_terms(y, B * a + gamma, dy);
    const VectorX tree_effort = B.transpose() * terms.sum, engine_effort = M.value * a + h.value;
    const double scale = numerics::max_coefficient(B.cwiseAbs().transpose() * terms.size);
    if (!tree_effort.allFinite() || !engine_effort.allFinite()) return false;
    error = std::max(error, relative_error(numerics::max_abs(tree_effort - engine_effort), scale));
    double other_error = max_derived_error(y);
    if (sheet_.reduced) other_error = std::max(other_error, reduced_error(y, v, a, engine_effort, scale));
    if (sheet_.regressor)
      other_error = std::max(other_error,
                             max_regressor_error(sheet_, texts_, engine_, {to_list(y), dy, B * a + gamma, B, q, v, a}));
    if (sheet_.natural && std::isfinite(other_error))
      other_error =
          std::max(other_error, max_natural_error(sheet_, texts_, mechanism_, values_at(y).names, all_coordinates(y)));
    if (sheet_.speeds) {
      const double speeds_error = max_speeds_error(y);
      if (!std::isfinite(speeds_error)) return false;
      other_error = std::max(other_error, speeds_error);
    }
    error = std::max(error, other_error);
    return std::isfinite(other_error);
  }

 private:
  /// Removes what formulas of the pose do not model, and what would only obstruct the engine.
  static Mechanism remove_unmodelled(const FormulaSheet& sheet, Mechanism mechanism) {
    mechanism.friction.clear();
    mechanism.loads.clear();
    mechanism.force_elements.clear();
    mechanism.constraints.clear();
    for (Joint& joint : mechanism.joints) joint.slips = true;
    const InverseDynamics chosen(mechanism, engine_options(sheet, mechanism));
    mechanism.torque_distribution.reset();
    mechanism.actuators.clear();  // efforts along the independent coordinates themselves
    for (const std::string& name : chosen.independent())
      for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
        if (mechanism.coordinates[c].name == name) mechanism.actuators.push_back(static_cast<int>(c));
    return mechanism;
  }

  /// Equations in independent coordinates are compared in those.
  static InverseOptions engine_options(const FormulaSheet& sheet, const Mechanism& mechanism) {
    InverseOptions options;
    options.independent = coordinate_names(mechanism, sheet.equations.tree, sheet.independent);
    return options;
  }

  bool is_slide(Eigen::Index column) const {
    return is_length_coordinate(mechanism_, sheet_.equations.tree.coordinates[static_cast<std::size_t>(column)]);
  }

  /// Smallest pivot over the largest of closures and independent coordinates, in angles and characteristic lengths.
  double regularity(MatrixX rows) const {
    if (n_ == 0) return 1;
    for (Eigen::Index c = 0; c < n_; ++c)
      if (is_slide(c)) rows.col(c) *= length_;
    for (Eigen::Index r = 0; r < rows.rows(); ++r) {  // a row is a length if it has the size of one
      const double square = rows.row(r).squaredNorm();
      if (length_ < 1 ? square < length_ : square > length_) rows.row(r) /= length_;
    }
    numerics::ColumnPivotingQr factors(rows);
    return std::abs(factors.matrixQR()(n_ - 1, n_ - 1)) / factors.maxPivot();
  }

  /// Mechanisms that are near a singularity wherever they go are compared there, with fewer digits to spare.
  double min_regularity() const {
    return attempts_ <= attempts_per_offset ? min_pose_regularity : 0.1 * min_pose_regularity;
  }

  VectorX random_vector(Eigen::Index size, double bound) {
    std::uniform_real_distribution<double> uniform(-bound, bound);
    VectorX v(size);
    for (double& x : v) x = uniform(random_);
    return v;
  }

  /// The values of all names at a pose; the last ones are cached.
  struct Values {
    std::vector<double> y;
    std::map<std::string, double> names;
    PoseValues pose;
  };
  const Values& values_at(const VectorX& y) {
    if (values_.y == to_list(y)) return values_;
    values_ = {to_list(y), evaluate_names(sheet_, to_list(y)), {}};
    PoseValues& pose = values_.pose;
    pose = evaluate_pose(*sheet_.ring, values_.names);
    for (const SheetSection& section : sheet_.sections)
      for (const SheetFormula& formula : section.formulas)
        if (formula.symbol >= 0)
          values_.names[formula.label()] = pose.symbols[static_cast<std::size_t>(formula.symbol)] =
              evaluate_formula(formula, pose.symbols, pose.angles);
    return values_;
  }

  double polynomial_at(const Polynomial& p, const VectorX& y) { return p.is_zero() ? 0 : values_at(y).pose(p); }

  double sum_term_sizes(const Polynomial& p, const VectorX& y) {
    double size = 0;
    for (const Term& term : p.terms())
      size += std::abs(polynomial_at(Polynomial::of_terms(sheet_.ring.get(), {term}), y));
    return size;
  }

  double printed_at(const std::string& label, const Polynomial& p, const VectorX& y) {
    const auto text = texts_.find(label);
    return text != texts_.end() ? evaluate_text(text->second, values_at(y).names) : polynomial_at(p, y);
  }

  /// Conditions, closures, solved closures and lengths of springs consist of entries that are compared with the engine:
  /// the printed texts must equal their polynomials.
  double max_derived_error(const VectorX& y) {
    std::map<std::string, double> names = values_at(y).names;
    double max_error = 0;
    for (std::size_t s = 0; s < sheet_.sections.size(); ++s)
      for (std::size_t k = 0; k < sheet_.sections[s].formulas.size(); ++k) {
        const SheetFormula& formula = sheet_.sections[s].formulas[k];
        const SheetSectionKind section = sheet_.sections[s].section;
        using enum SheetSectionKind;
        const bool is_derived = section == conditions || section == solved || section == closures ||
                                section == efforts || section == reduced || section == speeds || section == solutions ||
                                section == balanced || formula.name.ends_with("^2");
        const auto text = texts_.find(text_key(s, k, section, formula.label()));
        if (!is_derived || text == texts_.end()) continue;
        const double denominator = polynomial_at(formula.denominator, y);
        double value = polynomial_at(formula.value, y) / denominator;
        double size = sum_term_sizes(formula.value, y) / std::abs(denominator);
        for (const FormulaProduct& product : formula.products) {
          const double part = polynomial_at(product.numerator, y) / polynomial_at(product.denominator, y) *
                              polynomial_at(product.factor, y);
          value += part;
          size += std::abs(part);
        }
        if (!std::isfinite(value) && section == solutions) continue;  // a factor that must not vanish does
        const double deviation = std::abs(evaluate_text(text->second, names) - value);
        max_error = std::max(max_error, relative_error(deviation, size));
      }
    return max_error;
  }

  /// Steps of an elimination lose digits where they divide by little.
  bool has_small_pivot(const VectorX& y) {
    return std::any_of(sheet_.pivots.begin(), sheet_.pivots.end(), [&](const auto& pivot) {
      return !(std::abs(polynomial_at(pivot.first, y)) > min_regularity() * pivot.second);
    });
  }

  /// The torques in the independent coordinates from the printed steps, one after the other. Whatever is wrong in a step
  /// shows in these.
  double reduced_error(const VectorX& y, const VectorX& v, const VectorX& a, const VectorX& expected, double scale) {
    const auto printed = printed_reduced_pose(y);
    if (!printed) return 0;
    const PoseValues& pose = *printed;
    const ReducedEquations& e = *sheet_.reduced;
    const auto component = [](const VectorX& x, std::size_t i) { return x[static_cast<Eigen::Index>(i)]; };
    double max_error = 0;
    const std::size_t d = e.independent.size();
    for (std::size_t i = 0; i < d; ++i) {
      double torque = pose(e.z[i]);
      for (std::size_t j = 0; j < d; ++j) {
        torque += pose(e.M[i][j]) * component(a, j);
        for (std::size_t k = j; k < d; ++k)
          torque += (j == k ? 1 : 2) * pose(e.D[i][j][k]) * component(v, j) * component(v, k);
      }
      max_error = std::max(max_error, relative_error(torque - component(expected, i), scale));
    }
    return max_error;
  }

  /// The values of what the steps define, up to the section `reduced`; nothing if one is not printed.
  std::optional<PoseValues> printed_reduced_pose(const VectorX& y) {
    std::map<std::string, double> names = values_at(y).names;
    for (std::size_t s = 0; s < sheet_.sections.size(); ++s) {
      const SheetSection& section = sheet_.sections[s];
      for (std::size_t k = 0; k < section.formulas.size(); ++k) {
        const SheetFormula& formula = section.formulas[k];
        if (formula.symbol < 0) continue;
        const auto text = texts_.find(text_key(s, k, section.section, formula.label()));
        if (text == texts_.end()) return std::nullopt;
        names[formula.label()] = evaluate_text(text->second, names);
      }
      if (section.section == SheetSectionKind::reduced) break;
    }
    return evaluate_pose(*sheet_.ring, names);
  }

  double printed_entry(const std::string& name, std::initializer_list<std::size_t> indices, std::size_t count,
                       const Polynomial& p, const VectorX& y) {
    return printed_at(name + index_text(indices, count), p, y);
  }

  /// The equations in chosen speeds against those of the engine in the same speeds. Infinite where these do not
  /// determine the motion well.
  double max_speeds_error(const VectorX& y) {
    const SpeedFormulas& s = *sheet_.speeds;
    const std::size_t n = s.independent.size(), all = std::max(n, s.names.size());
    if (!terms_) terms_.emplace(mechanism_, engine_options(sheet_, mechanism_));
    const VectorX coordinates = all_coordinates(y);
    VectorX q(terms_->degrees_of_freedom());
    for (Eigen::Index k = 0; k < q.size(); ++k) q[k] = coordinates[terms_->independent()[static_cast<std::size_t>(k)]];
    if (!assemble_terms(q, coordinates)) return std::numeric_limits<double>::infinity();
    const auto found = terms_->speed_terms(q, {sheet_.chosen_speeds.in(mechanism_), {}});
    const auto plain = terms_->independent_terms(q);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    if (!found || !plain || found.value.independent != s.independent) return infinity;
    MatrixX rows = found.value.rows(found.value.independent, Eigen::all);
    // speeds have different units, and some coordinates move them little
    for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
    for (Eigen::Index c = 0; c < rows.cols(); ++c) rows.col(c).stableNormalize();
    const VectorX values = numerics::singular_values(rows);
    if (values[values.size() - 1] < min_pose_regularity * values[0]) return infinity;
    const dynamics::IndependentTerms& engine = found.value.speed_equations;
    double M_error = 0, w_error = 0, z_error = 0, w_scale = numerics::max_abs(engine.mass);
    const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(i); };
    for (std::size_t i = 0; i < n; ++i) {
      w_scale = std::max(w_scale, numerics::max_abs(engine.velocity[i]));
      z_error = std::max(z_error, std::abs(printed_entry("z", {i}, n, s.z[i], y) - engine.static_terms.sum()[at(i)]));
      for (std::size_t j = 0; j < n; ++j) {
        if (j >= i)
          M_error =
              std::max(M_error, std::abs(printed_entry("M", {i, j}, n, s.M[i][j], y) - engine.mass(at(i), at(j))));
        for (std::size_t k = j; k < n; ++k)
          w_error = std::max(
              w_error, std::abs(printed_entry("w", {i, j, k}, n, s.w[i][j][k], y) - engine.velocity[i](at(j), at(k))));
      }
    }
    double moment =
        numerics::max_abs(plain.value.static_terms.sum());  // of balanced mechanisms: of the terms that cancel
    for (const Polynomial& entry : sheet_.equations.z) moment = std::max(moment, sum_term_sizes(entry, y));
    const double z_scale = numerics::max_abs(found.value.rates) * moment;
    return std::max({relative_error(M_error, numerics::max_abs(engine.mass)), relative_error(w_error, w_scale),
                     relative_error(z_error, z_scale), max_relation_error(found.value, all, y)});
  }

  /// In the pose's assembly mode.
  bool assemble_terms(const VectorX& q, const VectorX& coordinates) {
    if (sheet_.equations.closure.empty()) return true;
    std::vector<CoordinateValue> values;
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c)
      values.push_back({static_cast<int>(c), coordinates[static_cast<Eigen::Index>(c)]});
    const auto found = terms_->assemble(q, values);
    if (!found) return false;
    double difference = 0;
    for (Eigen::Index c = 0; c < coordinates.size(); ++c)
      difference =
          std::max(difference, std::abs(std::remainder(found.value[c] - coordinates[c], 2 * std::numbers::pi)));
    return difference < max_assembly_difference;
  }

  /// Of the speeds that follow from the independent ones.
  double max_relation_error(const dynamics::SpeedTerms& engine, std::size_t count, const VectorX& y) {
    const SpeedFormulas& s = *sheet_.speeds;
    const double scale = numerics::max_abs(engine.transformation);
    double error = 0, product_error = 0, product_scale = scale;
    std::size_t row = 0;
    for (std::size_t i = 0; i < s.names.size(); ++i) {
      if (s.is_independent(i)) continue;
      product_scale = std::max(product_scale, numerics::max_abs(engine.acceleration[i]));
      for (std::size_t j = 0; j < s.independent.size(); ++j) {
        const auto r = static_cast<Eigen::Index>(i), c = static_cast<Eigen::Index>(j);
        error = std::max(
            error, std::abs(printed_entry(s.C_name, {i, j}, count, s.C[row][j], y) - engine.transformation(r, c)));
        for (std::size_t k = j; k < s.independent.size(); ++k)
          product_error =
              std::max(product_error, std::abs(printed_entry(s.c_name, {i, j, k}, count, s.c[row][j][k], y) -
                                               engine.acceleration[i](c, static_cast<Eigen::Index>(k))));
      }
      ++row;
    }
    return std::max(relative_error(error, scale), relative_error(product_error, product_scale));
  }

  MatrixX jacobian(const VectorX& y) {
    const Matrix& A = sheet_.equations.A;
    MatrixX value(static_cast<Eigen::Index>(A.size()), n_);
    for (std::size_t i = 0; i < A.size(); ++i)
      for (std::size_t j = 0; j < A[i].size(); ++j)
        value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
            printed_at("A" + index_text({i, j}, std::max(A.size(), A[i].size())), A[i][j], y);
    return value;
  }

  /// Ȧ ẏ.
  VectorX quadratic(const VectorX& y, const VectorX& dy) {
    const SymbolicEquations& e = sheet_.equations;
    VectorX sum = VectorX::Zero(static_cast<Eigen::Index>(e.A.size()));
    for (std::size_t i = 0; i < e.A.size(); ++i)
      for (std::size_t j = 0; j < e.A[i].size(); ++j)
        for (Eigen::Index k = 0; k < n_; ++k)
          sum[static_cast<Eigen::Index>(i)] +=
              polynomial_at(column_derivative(e.tree, e.A[i][j], static_cast<int>(k)), y) *
              dy[static_cast<Eigen::Index>(j)] * dy[k];
    return sum;
  }

  /// Rows that select the engine's independent coordinates from the tree's columns.
  MatrixX selection() const {
    const auto& names = engine_.independent();
    MatrixX S = MatrixX::Zero(static_cast<Eigen::Index>(names.size()), n_);
    for (std::size_t i = 0; i < names.size(); ++i)
      for (const auto& [column, ratio] : leader_terms(names[i]))
        S(static_cast<Eigen::Index>(i), column) = evaluate_polynomial(ratio);
    return S;
  }

  const std::vector<std::pair<int, Polynomial>>& leader_terms(const std::string& coordinate) const {
    static const std::vector<std::pair<int, Polynomial>> none;
    const SymbolicTree& tree = sheet_.equations.tree;
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c)
      if (mechanism_.coordinates[c].name == coordinate && tree.coordinate_variable[c] >= 0)
        return tree.variables[static_cast<std::size_t>(tree.coordinate_variable[c])].follows;
    return none;
  }

  /// Draws a random pose. With loops, it starts near the spec's rough values and moves to where the loops close.
  bool find_pose(VectorX& y) {
    const SymbolicEquations& e = sheet_.equations;
    // loops of which few poses close are tried nearer and nearer to the rough values
    const int reductions = attempts_++ / attempts_per_offset;
    y = random_vector(n_, e.closure.empty() ? 3 : 0.4 / (1 + reductions));
    if (e.closure.empty()) return true;
    for (Eigen::Index c = 0; c < n_; ++c)
      if (is_slide(c)) y[c] *= length_;
    y += rough_pose(e.tree, mechanism_.assembly);
    return close_loops(*sheet_.ring, e, y);
  }

  /// Refines the pose to the engine's assembled state, which must be in the same assembly mode.
  bool engine_pose(VectorX& y, VectorX& q) {
    q = selection() * y;
    closed_coordinates_.resize(0);
    if (sheet_.equations.closure.empty()) return true;
    const SymbolicTree& tree = sheet_.equations.tree;
    const auto assembly = assemble_engine(engine_, mechanism_, tree, q, y);
    if (!assembly) return false;
    for (Eigen::Index c = 0; c < n_; ++c)
      y[c] += std::remainder((*assembly)[tree.coordinates[static_cast<std::size_t>(c)]] - y[c], 2 * std::numbers::pi);
    closed_coordinates_ = *assembly;
    return true;
  }

  /// Coordinates of all joints, including those that close loops.
  VectorX all_coordinates(const VectorX& y) const {
    if (closed_coordinates_.size() > 0) return closed_coordinates_;
    const SymbolicTree& tree = sheet_.equations.tree;
    VectorX coordinates = VectorX::Zero(static_cast<Eigen::Index>(mechanism_.coordinates.size()));
    for (std::size_t c = 0; c < mechanism_.coordinates.size(); ++c) {
      if (tree.coordinate_variable[c] < 0) continue;
      const JointVariable& variable = tree.variables[static_cast<std::size_t>(tree.coordinate_variable[c])];
      double& x = coordinates[static_cast<Eigen::Index>(c)];
      x = evaluate_polynomial(variable.offset);
      for (const auto& [column, ratio] : variable.follows) x += evaluate_polynomial(ratio) * y[column];
    }
    return coordinates;
  }

  struct TreeTerms {
    VectorX sum, size;  ///< and the sum of the absolute values
  };
  /// M ÿ + D ẏ ẏ + z from the printed formulas.
  TreeTerms tree_terms(const VectorX& y, const VectorX& ddy, const VectorX& dy) {
    const SymbolicEquations& e = sheet_.equations;
    TreeTerms terms{VectorX::Zero(n_), VectorX::Zero(n_)};
    const auto n = static_cast<std::size_t>(n_);
    const auto add = [&](std::size_t i, double x) {
      terms.sum[static_cast<Eigen::Index>(i)] += x;
      terms.size[static_cast<Eigen::Index>(i)] += std::abs(x);
    };
    const auto component = [](const VectorX& v, std::size_t i) { return v[static_cast<Eigen::Index>(i)]; };
    for (std::size_t i = 0; i < n; ++i) {
      add(i, printed_at("D" + index_text({i}, n), e.z[i], y));
      for (std::size_t j = i; j < n; ++j) {
        const double M = printed_at("D" + index_text({i, j}, n), e.M[i][j], y);
        add(i, M * component(ddy, j));
        if (j > i) add(j, M * component(ddy, i));
      }
      for (std::size_t j = 0; j < n; ++j)
        for (std::size_t k = j; k < n; ++k) {
          const double D = printed_at("D" + index_text({i, j, k}, n), e.D[i][j][k], y);
          add(i, (j == k ? 1 : 2) * D * component(dy, j) * component(dy, k));
        }
    }
    return terms;
  }

  const FormulaSheet& sheet_;
  const std::map<std::string, std::string>& texts_;
  const Mechanism mechanism_;
  InverseDynamics engine_;
  std::optional<dynamics::EquationTerms> terms_;  ///< for chosen speeds
  double length_;                                 ///< characteristic [m]
  std::mt19937_64 random_;
  Eigen::Index n_;
  int attempts_ = 0;  ///< to find a pose
  Values values_;
  VectorX closed_coordinates_;  ///< the engine's coordinates; empty without loops
};

}  // namespace

std::map<std::string, double> evaluate_names(const FormulaSheet& sheet, const std::vector<double>& y) {
  std::map<std::string, double> values = evaluate_names(*sheet.ring, sheet.equations, y);
  if (!sheet.speeds) return values;
  PoseValues pose = evaluate_pose(*sheet.ring, values);
  evaluate_definitions(*sheet.speeds, pose.symbols, pose.angles);
  for (const SheetFormula& definition : sheet.speeds->definitions)
    values[definition.label()] = pose.symbols[static_cast<std::size_t>(definition.symbol)];
  return values;
}

namespace {

/// Updates symbols that are not the spec's but depend on its numbers.
void update_aliases(const FormulaSheet& sheet, const Mechanism& mechanism) {
  if (!sheet.natural) return;
  if (const int unit = sheet.equations.tree.basic_points->length_symbol; unit >= 0)
    sheet.ring->set_value(unit, verification::natural::choose_basic_points(mechanism).length);
  for (const auto& [symbol, sum] : sheet.natural->aliases) sheet.ring->set_value(symbol, evaluate_polynomial(sum));
}

/// Compares states with other numbers. @return how many
int compare_at_perturbed_parameters(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                                    const ParameterSampler& sampler, std::uint64_t seed, double& error) {
  std::mt19937_64 random(seed);
  return sampler.compare_perturbed(perturbed_state_count, random, [&](const Mechanism& mechanism) {
    update_aliases(sheet, mechanism);
    EngineComparison comparison(sheet, texts, mechanism, random());
    for (int attempts = 0; attempts < max_perturbed_pose_attempts; ++attempts)
      if (comparison.compare(error)) return true;
    return false;
  });
}

}  // namespace

FormulaCheck check_against_engine(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                                  const Mechanism& spec_mechanism, const FormulaCheckOptions& options) {
  FormulaCheck check;
  const Mechanism mechanism = attach_payloads(spec_mechanism);
  EngineComparison comparison(sheet, texts, mechanism, options.seed);
  const ParameterSampler sampler(*sheet.ring, *sheet.equations.tree.model);
  const bool has_other_numbers = options.with_perturbed_parameters && sampler.has_parameters();
  if (has_other_numbers)
    check.states = check.perturbed_states =
        compare_at_perturbed_parameters(sheet, texts, sampler, options.seed, check.error);
  if (has_other_numbers && check.perturbed_states == 0)
    check.note = "not checked at other numbers: none of " + std::to_string(ParameterSampler::max_draws) +
                 " draws gave a mechanism that can be assembled";
  for (int attempts = 0; check.states < options.states && attempts < max_pose_attempts; ++attempts)
    if (comparison.compare(check.error)) ++check.states;
  check.is_consistent = check.states == options.states && check.error < check_tolerance;
  if (options.with_perturbed_parameters && check.is_consistent)
    check_solution(sheet, texts, mechanism, options.seed, check);
  if (check.states < options.states)
    check.reason = "not enough poses were found at which the loops close";
  else if (!check.is_consistent && check.reason.empty())
    check.reason = "the formulas differ from the engine";
  return check;
}

namespace {

class NaturalComparison {
 public:
  NaturalComparison(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                    verification::natural::NaturalTerms expected, std::map<std::string, double> names)
      : natural_(*sheet.natural),
        texts_(texts),
        ring_(*sheet.ring),
        expected_(std::move(expected)),
        names_(std::move(names)) {
    for (std::size_t u = 0; u < natural_.unknowns.size(); ++u)
      unknown(u) = expected_.position(static_cast<Eigen::Index>(u / 2), static_cast<Eigen::Index>(u % 2));
  }

  double error() { return std::max({mass_error(), coefficient_error(), constraint_error(), jacobian_error()}); }

 private:
  double& unknown(std::size_t u) { return names_[ring_.symbol(natural_.unknowns[u]).name]; }

  double value(const std::string& label, const Polynomial& p) const {
    if (p.is_zero()) return 0;
    const auto text = texts_.find(label);
    return text != texts_.end() ? evaluate_text(text->second, names_) : evaluate_pose(ring_, names_)(p);
  }

  double mass_error() const {
    const std::size_t p = natural_.points.size();
    double max_error = 0;
    for (std::size_t i = 0; i < p; ++i)
      for (std::size_t j = i; j < p; ++j) {
        const auto row = static_cast<Eigen::Index>(2 * i), column = static_cast<Eigen::Index>(2 * j);
        const std::string indices = index_text({i, j}, p);
        max_error =
            std::max({max_error, std::abs(value("Mre" + indices, natural_.mass[i][j].re) - expected_.mass(row, column)),
                      std::abs(value("Mim" + indices, natural_.mass[i][j].im) - expected_.mass(row + 1, column))});
      }
    return relative_error(max_error, numerics::max_abs(expected_.mass));
  }

  double coefficient_error() const {
    const std::size_t p = natural_.points.size();
    double max_error = 0, scale = 0;
    for (std::size_t i = 0; i < p; ++i) {
      const std::complex<double> C = expected_.coefficients[i].coefficient;
      const std::string indices = index_text({i}, p);
      max_error =
          std::max(max_error, std::abs(std::complex<double>(value("Cre" + indices, natural_.coefficients[i].re),
                                                            value("Cim" + indices, natural_.coefficients[i].im)) -
                                       C));
      scale = std::max(scale, std::abs(C));
    }
    return relative_error(max_error, scale);
  }

  double constraint(std::size_t r) const {
    const std::size_t count = std::max(natural_.constraint.size(), natural_.unknowns.size());
    return value("Phi" + index_text({r}, count), natural_.constraint[r]);
  }

  double constraint_error() const {
    double max_error = 0;
    for (std::size_t r = 0; r < natural_.constraint.size(); ++r)
      max_error = std::max(max_error, std::abs(constraint(r)));
    return max_error / elementary::pow(expected_.unit + max_coordinate(), 2);
  }

  /// Maximum coordinate of any point [m].
  double max_coordinate() const { return numerics::max_abs(expected_.position); }

  double jacobian_error() {
    const double step = expected_.unit + max_coordinate();
    const std::size_t count = std::max(natural_.constraint.size(), natural_.unknowns.size());
    double max_error = 0, scale = 0;
    for (std::size_t u = 0; u < natural_.unknowns.size(); ++u)
      for (std::size_t r = 0; r < natural_.constraint.size(); ++r) {
        const double printed = value("G" + index_text({r, u}, count), natural_.jacobian[r][u]), centre = unknown(u);
        unknown(u) = centre + step;
        const double forward_value = constraint(r);
        unknown(u) = centre - step;
        const double backward_value = constraint(r);
        unknown(u) = centre;
        max_error = std::max(max_error, std::abs((forward_value - backward_value) / (2 * step) - printed));
        scale = std::max({scale, std::abs(printed), (std::abs(forward_value) + std::abs(backward_value)) / step});
      }
    return relative_error(max_error, scale);
  }

  const NaturalEquations& natural_;
  const std::map<std::string, std::string>& texts_;
  const Ring& ring_;
  verification::natural::NaturalTerms expected_;
  std::map<std::string, double> names_;
};

}  // namespace

double max_natural_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                         const Mechanism& mechanism, std::map<std::string, double> names, const VectorX& coordinates) {
  verification::natural::NaturalTerms expected = verification::natural::compute_natural_terms(mechanism, coordinates);
  if (expected.points != sheet.natural->points) return std::numeric_limits<double>::quiet_NaN();
  return NaturalComparison(sheet, texts, std::move(expected), std::move(names)).error();
}

namespace {

/// Values of all names, including rates and accelerations.
std::map<std::string, double> names_of(const FormulaSheet& sheet, const RegressorState& state) {
  auto names = evaluate_names(sheet, state.y);
  const SymbolicRegressor& regressor = *sheet.regressor;
  for (std::size_t c = 0; c < regressor.rates.size(); ++c) {
    names[sheet.ring->symbol(regressor.rates[c]).name] = state.dy[static_cast<Eigen::Index>(c)];
    names[sheet.ring->symbol(regressor.accelerations[c]).name] = state.ddy[static_cast<Eigen::Index>(c)];
  }
  return names;
}

MatrixX printed_regressor(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                          const std::map<std::string, double>& names) {
  const PoseValues pose = evaluate_pose(*sheet.ring, names);
  const Matrix& Y = sheet.regressor->Y;
  MatrixX value(static_cast<Eigen::Index>(Y.size()), static_cast<Eigen::Index>(sheet.regressor->parameters.size()));
  for (std::size_t i = 0; i < Y.size(); ++i)
    for (std::size_t p = 0; p < Y[i].size(); ++p) {
      const auto text = texts.find("Y" + index_text({i, p}, std::max(Y.size(), Y[i].size())));
      value(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(p)) =
          text != texts.end() ? evaluate_text(text->second, names) : pose(Y[i][p]);
    }
  return value;
}

}  // namespace

double max_regressor_error(const FormulaSheet& sheet, const std::map<std::string, std::string>& texts,
                           InverseDynamics& engine, const RegressorState& state) {
  const auto expected = engine.regressor(state.q, state.rate, state.acceleration);
  if (!expected) return std::numeric_limits<double>::quiet_NaN();
  const MatrixX Y = printed_regressor(sheet, texts, names_of(sheet, state));
  if (Y.cols() != expected.value.effort.cols()) return std::numeric_limits<double>::quiet_NaN();
  const MatrixX projected_regressor = state.B.transpose() * Y, size = state.B.cwiseAbs().transpose() * Y.cwiseAbs();
  const auto kind = [&](Eigen::Index p) { return expected.value.parameters[static_cast<std::size_t>(p)].kind; };
  std::map<dynamics::ParameterKind, double>
      scale;  // a column that cancels completely has the round-off of others of its unit
  for (Eigen::Index p = 0; p < Y.cols(); ++p) scale[kind(p)] = std::max(scale[kind(p)], numerics::max_abs(size.col(p)));
  double max_error = 0;
  for (Eigen::Index p = 0; p < Y.cols(); ++p) {
    const double deviation = numerics::max_abs(projected_regressor.col(p) - expected.value.effort.col(p));
    max_error = std::max(max_error, relative_error(deviation, scale[kind(p)]));
  }
  return max_error;
}

}  // namespace balance::formulas
