#include "balance/synthesis/formulas/closure_elimination.hpp"

#include "balance/foundation/numerics/block_triangular.hpp"
#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/foundation/numerics/extrema.hpp"
#include "balance/mechanics/dynamics/inverse_dynamics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

namespace balance::formulas {

namespace {

constexpr std::size_t sampled_pose_count = 4;
constexpr std::uint64_t pose_seed = 7;
/// Below this, relative to the largest pivot, a closure counts as dependent on others.
constexpr double rank_threshold = 1e-6;

/// Larger blocks of closures are eliminated step by step: their determinant is longer than the closures.
constexpr std::size_t max_cofactor_closures = 4;
/// Products of terms in a determinant, and terms of a numerator, beyond which closures are eliminated in steps.
constexpr double max_determinant_products = 2000;
constexpr std::size_t max_determinant_terms = 30, max_numerator_terms = 60;
/// A pivot may be this much smaller than the largest one if fewer entries change.
constexpr double pivot_preference = 0.1;

/// Adds a multiple of a relation, which is zero, to an argument.
CircularFunction apply_relation(const CircularFunction& function, const AngleRelation& relation, int times) {
  std::map<int, int> argument(function.argument.begin(), function.argument.end());
  for (const auto& [angle, multiple] : relation.multiples) argument[angle] += times * multiple;
  argument[relation.angle] -= times;
  CircularFunction shifted{function.group, function.is_sine, {}};
  for (const auto& [angle, multiple] : argument)
    if (multiple != 0) shifted.argument.emplace_back(angle, multiple);
  return shifted;
}

int argument_length(const CircularFunction& function) {
  int length = 0;
  for (const auto& [angle, multiple] : function.argument) length += std::abs(multiple);
  return length;
}

}  // namespace

Polynomial determinant(const Matrix& A) {
  if (A.empty()) return {1};
  Polynomial sum;
  for (std::size_t j = 0; j < A.size(); ++j)
    if (!A[0][j].is_zero()) sum += A[0][j] * cofactor(A, 0, j);
  return sum;
}

Polynomial cofactor(const Matrix& A, std::size_t row, std::size_t column) {
  Matrix minor = A;
  minor.erase(minor.begin() + static_cast<std::ptrdiff_t>(row));
  for (Row& entries : minor) entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(column));
  return (row + column) % 2 == 0 ? determinant(minor) : -determinant(minor);
}

Polynomial shorten_angle_sums(const SymbolicTree& tree, const Polynomial& p) {
  std::vector<Term> terms;
  for (const Term& term : p.terms()) {
    Term best = term;
    if (term.wave != 0) {
      TrigonometricMonomial trig = p.ring()->wave(term.wave);
      for (CircularFunction& function : trig)
        for (const AngleRelation& relation : tree.relations)
          for (const int times : {-2, -1, 1, 2}) {
            if (p.ring()->angle(relation.angle).group != function.group) continue;
            const CircularFunction shifted = apply_relation(function, relation, times);
            if (argument_length(shifted) < argument_length(function)) function = shifted;
          }
      best.wave = p.ring()->canonicalise(std::move(trig), best.coefficient);
    }
    terms.push_back(best);
  }
  return Polynomial::of_terms(p.ring(), std::move(terms));
}

Mechanism without_speed_constraints(Mechanism mechanism) {
  mechanism.constraints.clear();
  for (Joint& joint : mechanism.joints) joint.slips = true;
  return mechanism;
}

// Which columns are independent.

namespace {

Eigen::Index rank_of(const MatrixX& matrix) {
  if (matrix.size() == 0) return 0;
  numerics::ColumnPivotingQr solver;
  solver.setThreshold(rank_threshold);
  solver.compute(matrix);
  return solver.rank();
}

/// Columns in the order in which they are tried.
std::vector<std::size_t> list_candidates(const Mechanism& mechanism, const SymbolicTree& tree,
                                         const std::vector<std::string>& names) {
  std::vector<std::size_t> candidates;
  const auto add = [&](std::size_t column) {
    if (std::find(candidates.begin(), candidates.end(), column) == candidates.end()) candidates.push_back(column);
  };
  const auto add_coordinate = [&](int coordinate) {
    for (std::size_t c = 0; c < tree.columns.size(); ++c)
      if (tree.coordinates[c] == coordinate) add(c);
  };
  for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
    if (std::find(names.begin(), names.end(), mechanism.coordinates[c].name) != names.end())
      add_coordinate(static_cast<int>(c));
  if (!names.empty()) return candidates;
  try {
    const InverseDynamics engine(without_speed_constraints(mechanism));
    for (std::size_t c = 0; c < mechanism.coordinates.size(); ++c)
      if (const auto& independent = engine.independent();
          std::find(independent.begin(), independent.end(), mechanism.coordinates[c].name) != independent.end())
        add_coordinate(static_cast<int>(c));
  } catch (const std::invalid_argument&) {  // the engine does not assemble it; other columns may do
  }
  for (const int actuator : mechanism.actuators) {
    add_coordinate(actuator);
    const int variable = tree.coordinate_variable[static_cast<std::size_t>(actuator)];
    if (variable < 0) continue;
    for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(variable)].follows)
      add(static_cast<std::size_t>(column));
  }
  for (std::size_t c = 0; c < tree.columns.size(); ++c) add(c);
  return candidates;
}

/// Removes poses at which the Jacobian has not its greatest rank.
Eigen::Index remove_singular_poses(std::vector<VectorX>& poses, std::vector<MatrixX>& jacobians) {
  Eigen::Index rank = 0;
  for (const MatrixX& A : jacobians) rank = std::max(rank, rank_of(A));
  for (std::size_t k = poses.size(); k-- > 0;) {
    if (rank_of(jacobians[k]) == rank) continue;
    jacobians.erase(jacobians.begin() + static_cast<std::ptrdiff_t>(k));
    poses.erase(poses.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return rank;
}

MatrixX select(const MatrixX& A, const std::vector<std::size_t>& rows, const std::vector<std::size_t>& columns) {
  MatrixX selected(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index r = 0; r < selected.rows(); ++r)
    for (Eigen::Index c = 0; c < selected.cols(); ++c)
      selected(r, c) = A(static_cast<Eigen::Index>(rows[static_cast<std::size_t>(r)]),
                         static_cast<Eigen::Index>(columns[static_cast<std::size_t>(c)]));
  return selected;
}

/// As many rows of the dependent columns, independent at all poses.
std::vector<std::size_t> choose_rows(const std::vector<MatrixX>& jacobians, const std::vector<std::size_t>& columns) {
  std::vector<std::size_t> rows;
  for (std::size_t r = 0; r < static_cast<std::size_t>(jacobians.front().rows()); ++r) {
    rows.push_back(r);
    const bool is_independent = std::all_of(jacobians.begin(), jacobians.end(), [&](const MatrixX& A) {
      return rank_of(select(A, rows, columns)) == static_cast<Eigen::Index>(rows.size());
    });
    if (!is_independent) rows.pop_back();
  }
  return rows;
}

}  // namespace

ClosureChoice choose_independent_columns(const Mechanism& mechanism, const SymbolicTree& tree,
                                         const std::vector<std::string>& names, std::vector<VectorX> poses,
                                         std::vector<MatrixX> jacobians) {
  if (poses.empty()) throw FormulaError("no pose was found at which the loops close");
  const Eigen::Index rank = remove_singular_poses(poses, jacobians);
  ClosureChoice choice;
  choice.poses = std::move(poses);
  const Eigen::Index columns = jacobians.front().cols();
  const auto determines_more = [&](const MatrixX& A) {
    MatrixX stacked(A.rows() + static_cast<Eigen::Index>(choice.independent.size()), columns);
    stacked.topRows(A.rows()) = A;
    for (Eigen::Index k = A.rows(); k < stacked.rows(); ++k)
      stacked.row(k) = Eigen::RowVectorXd::Unit(columns, choice.independent[static_cast<std::size_t>(k - A.rows())]);
    return rank_of(stacked) == rank + static_cast<Eigen::Index>(choice.independent.size());
  };
  for (const std::size_t c : list_candidates(mechanism, tree, names)) {
    if (static_cast<Eigen::Index>(choice.independent.size()) == columns - rank) break;
    choice.independent.push_back(static_cast<int>(c));
    if (!std::all_of(jacobians.begin(), jacobians.end(), determines_more)) choice.independent.pop_back();
  }
  const auto freedoms = static_cast<std::size_t>(columns - rank);
  if (!names.empty() && (names.size() != freedoms || choice.independent.size() != freedoms))
    throw IndependentCoordinatesError("these coordinates do not determine the motion, which has " +
                                      std::to_string(freedoms) + (freedoms == 1 ? " freedom" : " freedoms"));
  if (choice.independent.size() != freedoms) throw FormulaError("no coordinates determine the motion");
  std::sort(choice.independent.begin(), choice.independent.end());
  for (std::size_t c = 0; c < tree.columns.size(); ++c)
    if (!std::binary_search(choice.independent.begin(), choice.independent.end(), static_cast<int>(c)))
      choice.dependent.push_back(c);
  choice.rows = choose_rows(jacobians, choice.dependent);
  if (choice.rows.size() != choice.dependent.size())
    throw FormulaError("the loops do not determine the dependent coordinates");
  return choice;
}

ClosureChoice choose_independent_columns(const Ring& ring, const Mechanism& mechanism, const SymbolicEquations& e,
                                         const std::vector<std::string>& names) {
  if (!e.closure.empty()) {
    std::vector<VectorX> poses = find_closed_poses(rough_pose(e.tree, mechanism.assembly), sampled_pose_count,
                                                   pose_seed, [&](VectorX& y) { return close_loops(ring, e, y); });
    std::vector<MatrixX> jacobians;
    for (const VectorX& y : poses) jacobians.push_back(evaluate_pose(ring, e, y)(e.A, y.size()));
    return choose_independent_columns(mechanism, e.tree, names, std::move(poses), std::move(jacobians));
  }
  ClosureChoice choice;
  for (std::size_t c = 0; c < e.tree.columns.size(); ++c) choice.independent.push_back(static_cast<int>(c));
  return choice;
}

void check_independent_without_loops(const Mechanism& mechanism, const SymbolicTree& tree,
                                     const std::vector<std::string>& names) {
  const std::vector<std::string> columns = coordinate_names(mechanism, tree);
  if (names.empty() || (names.size() == columns.size() &&
                        std::set(names.begin(), names.end()) == std::set(columns.begin(), columns.end())))
    return;
  throw IndependentCoordinatesError(
      fmt::format("the mechanism has no loops: its independent coordinates are {}", fmt::join(columns, ", ")));
}

// The elimination.

namespace {

/// Closures that are solved together for as many dependent columns.
struct ClosureBlock {
  std::vector<std::size_t> columns, rows;  ///< of A
  bool has_cofactors = false;
  Matrix cofactors;        ///< transposed, per column and row
  Polynomial determinant;  ///< of several terms: a symbol's definition
  std::string name;        ///< of the determinant
  Polynomial divisor;      ///< the determinant itself, or its symbol
  Matrix upper, lower;     ///< of the elimination in steps, in the order of columns and rows
};

/// Products of terms in a determinant.
double count_determinant_products(const Matrix& A, std::size_t row = 0, std::size_t used = 0) {
  if (row == A.size()) return 1;
  double sum = 0;
  for (std::size_t j = 0; j < A.size(); ++j)
    if ((used >> j & 1) == 0 && !A[row][j].is_zero())
      sum += static_cast<double>(A[row][j].size()) * count_determinant_products(A, row + 1, used | std::size_t{1} << j);
  return sum;
}

}  // namespace

class ClosureElimination::Implementation {
 public:
  Implementation(Ring& ring, const SymbolicEquations& equations, ClosureChoice choice)
      : ring_(ring), e_(equations), n_(equations.tree.columns.size()), choice_(std::move(choice)) {
    for (const VectorX& y : choice_.poses) samples_.push_back(evaluate_pose(ring_, e_, y));
    C_.assign(n_, Row(choice_.independent.size()));
    for (std::size_t u = 0; u < choice_.independent.size(); ++u)
      C_[static_cast<std::size_t>(choice_.independent[u])][u] = 1;
    make_blocks();
    for (std::size_t u = 0; u < choice_.independent.size(); ++u) solve_rate(u);
    is_closed_form_ = blocks_.size() <= 1 && pivots_.empty() && working_count_ == 0;
  }

  void derive_accelerations() {
    // since the rates were solved for, others may have added symbols to the ring, for which the samples have no values;
    // only the choice of pivots reads them
    samples_.clear();
    steps_ = &acceleration_steps_;
    const std::size_t d = choice_.independent.size();
    c_.assign(n_, Matrix(d, Row(d)));
    if (choice_.rows.empty()) return;
    list_second_derivatives();
    for (std::size_t j = 0; j < d; ++j)
      for (std::size_t k = j; k < d; ++k) solve_acceleration(j, k);
  }

  const ClosureChoice& choice() const { return choice_; }
  const Polynomial& rate(std::size_t column, std::size_t u) const { return C_[column][u]; }
  const Polynomial& acceleration(std::size_t column, std::size_t j, std::size_t k) const { return c_[column][j][k]; }
  const std::vector<SheetFormula>& rate_steps() const { return rate_steps_; }
  const std::vector<SheetFormula>& acceleration_steps() const { return acceleration_steps_; }
  const std::vector<EliminationPivot>& pivots() const { return pivots_; }
  bool is_closed_form() const { return is_closed_form_; }

 private:
  double max_size(const Polynomial& p) const {
    double size = 0;
    for (const PoseValues& pose : samples_) size = std::max(size, std::abs(pose(p)));
    return size;
  }
  /// At the first `count` poses.
  double min_size(const Polynomial& p, std::size_t count) const {
    double size = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count; ++k) size = std::min(size, std::abs(samples_[k](p)));
    return size;
  }
  double min_size(const Polynomial& p) const { return min_size(p, samples_.size()); }

  /// A symbol for a value; the value itself if that is a single term.
  Polynomial define(const std::string& name, const std::string& indices, Polynomial value, Polynomial divisor = 1,
                    const std::string& divisor_name = "", const Polynomial& divisor_symbol = 1) {
    if (value.is_zero() || (divisor == Polynomial(1) && value.size() == 1)) return value;
    steps_->push_back(define_formula(ring_, name, indices, std::move(value), std::move(divisor), divisor_name));
    const SheetFormula& step = steps_->back();
    for (PoseValues& pose : samples_)
      pose.symbols.push_back(pose(step.value) / pose(divisor_name.empty() ? step.denominator : divisor_symbol));
    return Polynomial::of_symbol(ring_, step.symbol);
  }
  /// A working quantity of the elimination.
  Polynomial define_working(Polynomial value, Polynomial divisor = 1) {
    if (value.is_zero() || (divisor == Polynomial(1) && value.size() == 1)) return value;
    return define("W", std::to_string(++working_count_), std::move(value), std::move(divisor));
  }

  void make_blocks() {
    numerics::SparsityPattern pattern;
    for (const std::size_t r : choice_.rows) {
      pattern.emplace_back();
      for (std::size_t c = 0; c < choice_.dependent.size(); ++c)
        if (!e_.A[r][choice_.dependent[c]].is_zero()) pattern.back().push_back(static_cast<int>(c));
    }
    const numerics::BlockTriangularForm form = numerics::find_block_triangular_form(pattern);
    if (!form.is_structurally_regular) throw FormulaError("the closures are singular");
    for (const std::vector<int>& rows : form.blocks) {
      ClosureBlock block;
      for (const int r : rows) {
        block.rows.push_back(choice_.rows[static_cast<std::size_t>(r)]);
        block.columns.push_back(
            choice_.dependent[static_cast<std::size_t>(form.matched_column[static_cast<std::size_t>(r)])]);
      }
      std::sort(block.columns.begin(), block.columns.end());
      blocks_.push_back(std::move(block));
    }
    std::size_t named = 0;
    for (ClosureBlock& block : blocks_) factorise(block, named);
  }

  Matrix entries_of(const ClosureBlock& block) const {
    Matrix A;
    for (const std::size_t r : block.rows) {
      A.emplace_back();
      for (const std::size_t c : block.columns) A.back().push_back(e_.A[r][c]);
    }
    return A;
  }

  void factorise(ClosureBlock& block, std::size_t& named) {
    Matrix A = entries_of(block);
    block.has_cofactors =
        A.size() <= max_cofactor_closures && count_determinant_products(A) <= max_determinant_products;
    if (block.has_cofactors) block.determinant = shorten_angle_sums(e_.tree, determinant(A));
    block.has_cofactors = block.has_cofactors && block.determinant.size() <= max_determinant_terms;
    if (!block.has_cofactors) return eliminate(block, std::move(A));
    if (block.determinant.is_zero() || min_size(block.determinant) == 0)
      throw FormulaError("the closures are singular");
    block.cofactors.assign(A.size(), Row(A.size()));
    for (std::size_t r = 0; r < A.size(); ++r)
      for (std::size_t c = 0; c < A.size(); ++c) block.cofactors[c][r] = cofactor(A, r, c);
    block.divisor = block.determinant;
    if (block.determinant.size() == 1) return;
    const std::string indices = blocks_.size() == 1 ? "" : std::to_string(++named);
    block.divisor = define("Delta", indices, block.determinant);
    block.name = steps_->back().label();
  }

  /// Gaussian elimination with pivots that are large at all sampled poses.
  void eliminate(ClosureBlock& block, Matrix A) {
    const std::size_t size = A.size(), labels = std::max(n_, e_.A.size());
    for (std::size_t r = 0; r < size; ++r)
      for (std::size_t c = 0; c < size; ++c)
        A[r][c] = define("A", index_text({block.rows[r], block.columns[c]}, labels), A[r][c]);
    block.lower.assign(size, Row(size));
    for (std::size_t s = 0; s < size; ++s) {
      exchange_for_pivot(block, A, s);
      const double least = min_size(A[s][s]);
      pivots_.push_back({A[s][s], least > rank_threshold * max_size(A[s][s]) ? least : min_size(A[s][s], 1)});
      for (std::size_t r = s + 1; r < size; ++r) {
        if (A[r][s].is_zero()) continue;
        block.lower[r][s] = define_working(A[r][s], A[s][s]);
        for (std::size_t c = s + 1; c < size; ++c)
          if (!A[s][c].is_zero()) A[r][c] = define_working(A[r][c] - block.lower[r][s] * A[s][c]);
        A[r][s] = 0;
      }
    }
    block.upper = std::move(A);
  }

  /// Sizes of the entries that are left, relative to their rows, at the first `count` poses.
  MatrixX relative_sizes(const Matrix& A, std::size_t s, std::size_t count) const {
    const std::size_t size = A.size();
    MatrixX sizes = MatrixX::Zero(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(size));
    for (std::size_t r = s; r < size; ++r) {
      double row_size = 0;
      for (std::size_t c = s; c < size; ++c) row_size = std::max(row_size, max_size(A[r][c]));
      for (std::size_t c = s; c < size && row_size > 0; ++c)
        sizes(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = min_size(A[r][c], count) / row_size;
    }
    return sizes;
  }

  void exchange_for_pivot(ClosureBlock& block, Matrix& A, std::size_t s) {
    const std::size_t size = A.size();
    MatrixX quality = relative_sizes(A, s, samples_.size());
    // other poses may be of another assembly mode, where other entries are large
    if (numerics::max_abs(quality) < rank_threshold) quality = relative_sizes(A, s, 1);
    const double best = numerics::max_abs(quality);
    if (best < rank_threshold) throw FormulaError("the closures are singular");
    const auto at = [&](std::size_t r, std::size_t c) {
      return quality(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c));
    };
    std::size_t row = s, column = s, fewest = std::numeric_limits<std::size_t>::max();
    for (std::size_t r = s; r < size; ++r)
      for (std::size_t c = s; c < size; ++c) {
        if (at(r, c) < pivot_preference * best) continue;
        std::size_t in_row = 0, in_column = 0;
        for (std::size_t k = s; k < size; ++k) in_row += !A[r][k].is_zero(), in_column += !A[k][c].is_zero();
        const std::size_t fill = (in_row - 1) * (in_column - 1);
        if (fill < fewest) fewest = fill, row = r, column = c;
      }
    std::swap(A[s], A[row]), std::swap(block.rows[s], block.rows[row]), std::swap(block.lower[s], block.lower[row]);
    for (Row& entries : A) std::swap(entries[s], entries[column]);
    std::swap(block.columns[s], block.columns[column]);
  }

  /// The unknowns of a block for A x = right-hand side. @param label the unknown's name and indices, by column
  using Label = std::function<std::pair<std::string, std::string>(std::size_t)>;
  std::vector<Polynomial> solve_block(const ClosureBlock& block, Row rhs, const Label& label) {
    return block.has_cofactors ? solve_by_cofactors(block, std::move(rhs), label)
                               : solve_by_elimination(block, std::move(rhs), label);
  }

  std::vector<Polynomial> solve_by_cofactors(const ClosureBlock& block, Row rhs, const Label& label) {
    const std::size_t size = rhs.size();
    std::size_t terms = 0;
    for (std::size_t c = 0; c < size; ++c)
      for (std::size_t r = 0; r < size; ++r) terms = std::max(terms, block.cofactors[c][r].size() * rhs[r].size());
    const bool is_expanded = terms <= max_numerator_terms;
    if (!is_expanded)
      for (Polynomial& entry : rhs) entry = define_working(shorten_angle_sums(e_.tree, entry));
    std::vector<Polynomial> unknowns;
    for (std::size_t c = 0; c < size; ++c) {
      Polynomial numerator;
      for (std::size_t r = 0; r < size; ++r) numerator += block.cofactors[c][r] * rhs[r];
      const auto [name, indices] = label(block.columns[c]);
      unknowns.push_back(
          define(name, indices, shorten_angle_sums(e_.tree, numerator), block.determinant, block.name, block.divisor));
    }
    return unknowns;
  }

  std::vector<Polynomial> solve_by_elimination(const ClosureBlock& block, Row rhs, const Label& label) {
    const std::size_t size = rhs.size();
    for (std::size_t r = 0; r < size; ++r) {
      for (std::size_t s = 0; s < r; ++s) rhs[r] -= block.lower[r][s] * rhs[s];
      rhs[r] = define_working(rhs[r]);
    }
    std::vector<Polynomial> unknowns(size);
    for (std::size_t s = size; s-- > 0;) {
      for (std::size_t c = s + 1; c < size; ++c) rhs[s] -= block.upper[s][c] * unknowns[c];
      const auto [name, indices] = label(block.columns[s]);
      unknowns[s] = define(name, indices, rhs[s], block.upper[s][s]);
    }
    return unknowns;
  }

  /// The blocks one after the other. @param rhs of a closure, without dependent columns
  /// @param label a column's unknown, by its name and indices @param unknown where it is stored
  template <class RightHandSide, class Unknown>
  void solve_blocks(const RightHandSide& rhs, const Label& label, const Unknown& unknown) {
    std::vector<std::size_t> known;
    for (const ClosureBlock& block : blocks_) {
      Row sums;
      for (const std::size_t r : block.rows) {
        sums.push_back(rhs(r));
        for (const std::size_t b : known) sums.back() -= e_.A[r][b] * unknown(b);
      }
      const auto unknowns = solve_block(block, std::move(sums), label);
      for (std::size_t k = 0; k < block.columns.size(); ++k) unknown(block.columns[k]) = unknowns[k];
      known.insert(known.end(), block.columns.begin(), block.columns.end());
    }
  }

  void solve_rate(std::size_t u) {
    const auto column = static_cast<std::size_t>(choice_.independent[u]);
    solve_blocks([&](std::size_t r) { return -e_.A[r][column]; },
                 [&](std::size_t c) {
                   return std::pair<std::string, std::string>("C", index_text({c, u}, n_));
                 },
                 [&](std::size_t c) -> Polynomial& { return C_[c][u]; });
  }

  void list_second_derivatives() {
    for (const std::size_t r : choice_.rows) {
      Matrix second(n_, Row(n_));
      for (std::size_t b = 0; b < n_; ++b)
        for (std::size_t c = b; c < n_; ++c)
          second[b][c] = second[c][b] = column_derivative(e_.tree, e_.A[r][b], static_cast<int>(c));
      second_derivatives_[r] = std::move(second);
    }
  }

  /// Σ ∂²h/∂y_b∂y_c C_bj C_ck, symmetric in j and k.
  Polynomial second_order(std::size_t row, std::size_t j, std::size_t k) const {
    const Matrix& second = second_derivatives_.at(row);
    Polynomial sum;
    for (std::size_t b = 0; b < n_; ++b)
      for (std::size_t c = b; c < n_; ++c) {
        if (second[b][c].is_zero()) continue;
        Polynomial rates = C_[b][j] * C_[c][k];
        if (c > b) rates += C_[c][j] * C_[b][k];
        sum += second[b][c] * rates;
      }
    return sum;
  }

  void solve_acceleration(std::size_t j, std::size_t k) {
    solve_blocks([&](std::size_t r) { return -second_order(r, j, k); },
                 [&](std::size_t c) {
                   return std::pair<std::string, std::string>("c", index_text({c, j, k}, n_));
                 },
                 [&](std::size_t c) -> Polynomial& { return c_[c][j][k]; });
    for (const std::size_t c : choice_.dependent) c_[c][k][j] = c_[c][j][k];
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  std::size_t n_;
  ClosureChoice choice_;
  std::vector<PoseValues> samples_;
  std::vector<ClosureBlock> blocks_;
  Matrix C_;
  std::vector<Matrix> c_;
  std::map<std::size_t, Matrix> second_derivatives_;
  std::vector<SheetFormula> rate_steps_, acceleration_steps_;
  std::vector<SheetFormula>* steps_ = &rate_steps_;
  std::vector<EliminationPivot> pivots_;
  int working_count_ = 0;
  bool is_closed_form_ = true;
};

ClosureElimination::ClosureElimination(Ring& ring, const SymbolicEquations& equations, ClosureChoice choice)
    : implementation_(std::make_unique<Implementation>(ring, equations, std::move(choice))) {}
ClosureElimination::~ClosureElimination() = default;

const std::vector<int>& ClosureElimination::independent() const { return implementation_->choice().independent; }
const std::vector<VectorX>& ClosureElimination::poses() const { return implementation_->choice().poses; }
const Polynomial& ClosureElimination::rate(std::size_t column, std::size_t u) const {
  return implementation_->rate(column, u);
}
const std::vector<SheetFormula>& ClosureElimination::rate_steps() const { return implementation_->rate_steps(); }
bool ClosureElimination::is_closed_form() const { return implementation_->is_closed_form(); }
void ClosureElimination::derive_accelerations() { implementation_->derive_accelerations(); }
const Polynomial& ClosureElimination::acceleration(std::size_t column, std::size_t j, std::size_t k) const {
  return implementation_->acceleration(column, j, k);
}
const std::vector<SheetFormula>& ClosureElimination::acceleration_steps() const {
  return implementation_->acceleration_steps();
}
const std::vector<EliminationPivot>& ClosureElimination::pivots() const { return implementation_->pivots(); }

}  // namespace balance::formulas
