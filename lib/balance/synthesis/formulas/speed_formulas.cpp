#include "balance/synthesis/formulas/speed_formulas.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/formulas/closed_poses.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/speed_rows.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <random>

namespace balance::formulas {

namespace {

/// More speeds that depend on each other are not solved for: the determinant becomes too long.
constexpr std::size_t max_solved_speeds = 4;
/// Longer entries get names where they occur in others.
constexpr std::size_t max_plain_terms = 2;
/// Longer rows of speeds in the tree's rates are referred to by name.
constexpr std::size_t max_inline_row_terms = 4;
constexpr double min_relative_pivot = 1e-6;  // of speeds that determine the motion, at a random pose
/// A speed that loops keep at zero is below this, relative to its terms, up to the round-off of the poses.
constexpr double zero_speed_tolerance = 1e-8;
/// At a single one, it may vanish by chance; some of the others may be of another assembly mode.
constexpr int min_zero_speed_poses = 2;

class SpeedDerivation {
 public:
  /// @param reduced nullptr without loops
  SpeedDerivation(Ring& ring, const SymbolicEquations& equations, const ReducedEquations* reduced)
      : ring_(ring),
        e_(equations),
        reduced_(reduced),
        columns_(equations.tree.columns.size()),
        n_(reduced ? reduced->independent.size() : columns_) {}

  SpeedFormulas derive(const std::vector<model::GeneralisedSpeed>& speeds) {
    if (n_ == 0) throw FormulaError("the mechanism has no degrees of freedom");
    if (reduced_) add_reduced();
    SpeedRows rows = derive_speed_rows(ring_, e_, speeds);
    out_.definitions.insert(out_.definitions.end(), rows.definitions.begin(), rows.definitions.end());
    rows_ = std::move(rows.rows);
    for (const model::GeneralisedSpeed& speed : speeds) out_.names.push_back(speed.name);
    if (reduced_)
      add_rows();
    else
      out_.W = rows_;
    choose_independent();
    solve();
    if (!reduced_) name_tree_terms();
    add_inertia();
    add_products();
    add_dependent();
    return std::move(out_);
  }

 private:
  const Polynomial& W(std::size_t i, std::size_t j) const {
    return out_.W[static_cast<std::size_t>(out_.independent[i])][j];
  }

  void add_reduced() {
    for (const auto* steps : {&reduced_->rate_steps, &reduced_->acceleration_steps, &reduced_->definitions})
      out_.definitions.insert(out_.definitions.end(), steps->begin(), steps->end());
    for (const SheetFormula& formula : reduced_->formulas)
      if (formula.symbol >= 0) out_.definitions.push_back(formula);
    D_ = reduced_->M, D3_ = reduced_->D, z_ = reduced_->z;
    out_.W_name = "Wbar", out_.C_name = "Cbar", out_.c_name = "cbar";
  }

  std::string speed_indices(const std::vector<std::size_t>& indices) const {
    return index_text(indices, std::max({columns_, n_, rows_.size()}));
  }

  /// An entry of a speed in the tree's rates, or its name.
  Polynomial row_entry(const std::string& name, const std::vector<std::size_t>& indices, const Polynomial& entry) {
    if (entry.size() <= max_inline_row_terms) return entry;
    const auto [known, is_new] = row_entries_.try_emplace(name + speed_indices(indices), Polynomial());
    if (is_new) known->second = define(name, speed_indices(indices), entry);
    return known->second;
  }

  Polynomial define_sum(SheetFormula formula) {
    const Polynomial value = name_sum(ring_, formula);
    if (formula.symbol >= 0) out_.definitions.push_back(std::move(formula));
    return value;
  }

  /// W = W̃ C, W̃ being the rows in the tree's rates.
  void add_rows() {
    const std::size_t count = std::max(n_, rows_.size());
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      out_.W.emplace_back();
      for (std::size_t j = 0; j < n_; ++j) {
        SheetFormula formula{out_.W_name, index_text({i, j}, count), {}};
        for (std::size_t a = 0; a < columns_; ++a)
          if (!reduced_->C[a][j].is_zero())
            add_multiple(formula, reduced_->C[a][j], row_entry("Wtilde", {i, a}, rows_[i][a]));
        out_.W.back().push_back(define_sum(std::move(formula)));
      }
    }
  }

  /// Symmetric coefficients of q̇_j q̇_k in the derivative of a speed, besides Σ W_ij q̈_j.
  Matrix second_order(std::size_t speed) {
    const Matrix products = row_products(speed);
    if (!reduced_) return products;
    const Matrix& C = reduced_->C;
    Matrix N(n_, Row(n_));
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t k = j; k < n_; ++k) {
        SheetFormula formula{"N", index_text({speed, j, k}, std::max(n_, rows_.size())), {}};
        for (std::size_t a = 0; a < columns_; ++a) {
          if (!reduced_->c[a][j][k].is_zero())
            add_multiple(formula, reduced_->c[a][j][k], row_entry("Wtilde", {speed, a}, rows_[speed][a]));
          for (std::size_t b = a; b < columns_; ++b) {
            Polynomial factor = C[a][j] * C[b][k];
            if (b > a) factor += C[b][j] * C[a][k];
            if (!factor.is_zero()) add_multiple(formula, factor, row_entry("Ntilde", {speed, a, b}, products[a][b]));
          }
        }
        N[j][k] = N[k][j] = define_sum(std::move(formula));
      }
    return N;
  }

  /// With the spec's numbers: at which the loops close, or a random one.
  std::vector<PoseValues> sample_poses() const {
    std::vector<PoseValues> poses;
    if (reduced_)
      for (const VectorX& y : reduced_->poses) poses.push_back(evaluate_pose(ring_, e_, y));
    else
      poses.push_back(draw_pose());
    for (PoseValues& pose : poses) evaluate_definitions(out_, pose.symbols, pose.angles);
    return poses;
  }

  PoseValues draw_pose() const {
    PoseValues pose;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const Symbol& symbol : ring_.symbols())
      pose.symbols.push_back(symbol.kind == SymbolKind::slide ? uniform(random) : symbol.value);
    for (const Angle& angle : ring_.angles()) pose.angles.push_back(angle.is_fixed ? angle.value : 3 * uniform(random));
    return pose;
  }

  /// The first speeds that determine the motion at a pose.
  void choose_independent() {
    const std::vector<PoseValues> poses = sample_poses();
    if (reduced_) check_speeds(poses);
    for (std::size_t i = 0; i < out_.W.size() && out_.independent.size() < n_; ++i) {
      out_.independent.push_back(static_cast<int>(i));
      const bool is_regular =
          std::any_of(poses.begin(), poses.end(), [&](const PoseValues& pose) { return has_full_rank(pose); });
      if (!is_regular) out_.independent.pop_back();
    }
    if (out_.independent.size() < n_)
      throw FormulaError("the speeds do not determine the motion: " + std::to_string(n_) +
                         " that are independent are needed");
  }

  /// A speed that is zero wherever the loops close, but not as a formula, would only show round-off.
  void check_speeds(const std::vector<PoseValues>& poses) const {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto is_zero = [&](const PoseValues& pose) {
        const double size = pose(Matrix{rows_[i]}, static_cast<Eigen::Index>(columns_)).norm() *
                            pose(reduced_->C, static_cast<Eigen::Index>(n_)).norm();
        const double rate = pose(Matrix{out_.W[i]}, static_cast<Eigen::Index>(n_)).norm();
        return rate < zero_speed_tolerance * size;
      };
      const bool has_terms =
          std::any_of(out_.W[i].begin(), out_.W[i].end(), [](const Polynomial& entry) { return !entry.is_zero(); });
      if (has_terms && std::count_if(poses.begin(), poses.end(), is_zero) >= min_zero_speed_poses)
        throw FormulaError("the speed " + out_.names[i] + " is zero wherever the loops close");
    }
  }

  bool has_full_rank(const PoseValues& pose) const {
    Matrix chosen;
    for (const int speed : out_.independent) chosen.push_back(out_.W[static_cast<std::size_t>(speed)]);
    MatrixX rows = pose(chosen, static_cast<Eigen::Index>(n_));
    for (Eigen::Index r = 0; r < rows.rows(); ++r) rows.row(r).stableNormalize();
    const VectorX values = numerics::singular_values(rows);
    return values[values.size() - 1] > min_relative_pivot * values[0];
  }

  /// Solves W q̇ = σ: rows with one unknown first, then the others by Cramer's rule.
  void solve() {
    out_.V.assign(n_, Row(n_));
    std::vector<bool> is_row_used(n_, false);
    is_known_.assign(n_, false);
    for (bool has_changed = true; has_changed;) {
      has_changed = false;
      for (std::size_t i = 0; i < n_; ++i) {
        if (is_row_used[i]) continue;
        const std::optional<std::size_t> column = single_unknown(i);
        if (!column) continue;
        const Row rest = remainder(i);
        const Polynomial inverse = power(W(i, *column), -1);
        out_.divisors.push_back(W(i, *column));
        for (std::size_t s = 0; s < n_; ++s) out_.V[*column][s] = inverse * rest[s];
        is_known_[*column] = is_row_used[i] = has_changed = true;
      }
    }
    std::vector<std::size_t> rows, columns;
    for (std::size_t k = 0; k < n_; ++k) {
      if (!is_row_used[k]) rows.push_back(k);
      if (!is_known_[k]) columns.push_back(k);
    }
    if (!rows.empty()) solve_core(rows, columns);
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t s = 0; s < n_; ++s) name_entry("V", {j, s}, out_.V[j][s]);
  }

  /// The only column of a row that is not known yet, if the row can be divided by its entry.
  std::optional<std::size_t> single_unknown(std::size_t i) const {
    std::optional<std::size_t> found;
    for (std::size_t j = 0; j < n_; ++j) {
      if (is_known_[j] || W(i, j).is_zero()) continue;
      if (found) return std::nullopt;
      found = j;
    }
    if (!found) return std::nullopt;
    const Polynomial& pivot = W(i, *found);
    return pivot.size() == 1 && pivot.terms()[0].wave == 0 ? found : std::nullopt;
  }

  /// σ_i without what the known columns contribute, per speed.
  Row remainder(std::size_t i) const {
    Row rest(n_);
    rest[i] = 1;
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t s = 0; is_known_[j] && s < n_; ++s) rest[s] -= W(i, j) * out_.V[j][s];
    return rest;
  }

  void solve_core(const std::vector<std::size_t>& rows, const std::vector<std::size_t>& columns) {
    if (rows.size() > max_solved_speeds)
      throw FormulaError(std::to_string(rows.size()) + " speeds depend on each other: formulas are found for at most " +
                         std::to_string(max_solved_speeds));
    Matrix core;
    for (const std::size_t row : rows) {
      core.emplace_back();
      for (const std::size_t column : columns) core.back().push_back(W(row, column));
    }
    const Polynomial det = determinant(core);
    if (det.is_zero()) throw FormulaError("the speeds do not determine the motion at any pose");
    std::string divisor;
    if (det.size() > 1) {
      out_.divisors.push_back(define("Delta", reduced_ ? "_W" : "", det));
      divisor = out_.definitions.back().label();
    } else {
      out_.divisors.push_back(det);
    }
    const char* name = columns.size() == n_ ? "V" : "K";  // with nothing else to add, these are the entries of V
    std::vector<Row> rest;
    for (const std::size_t row : rows) rest.push_back(remainder(row));
    for (std::size_t c = 0; c < columns.size(); ++c)
      for (std::size_t r = 0; r < rows.size(); ++r) {
        const Polynomial adjugate = cofactor(core, r, c);
        if (adjugate.is_zero()) continue;
        const bool is_whole = det.size() == 1 && det.terms()[0].wave == 0;
        const Polynomial inverse = is_whole
                                       ? adjugate * power(det, -1)
                                       : define(name, index_text({columns[c], rows[r]}, n_), adjugate, det, divisor);
        for (std::size_t s = 0; s < n_; ++s) out_.V[columns[c]][s] += inverse * rest[r][s];
      }
  }

  /// A new symbol with its definition.
  Polynomial define(const std::string& name, const std::string& indices, const Polynomial& numerator,
                    const Polynomial& denominator = 1, const std::string& denominator_name = "") {
    out_.definitions.push_back(define_formula(ring_, name, indices, numerator, denominator, denominator_name));
    return Polynomial::of_symbol(ring_, out_.definitions.back().symbol);
  }

  /// Replaces a long entry by a symbol.
  void name_entry(const std::string& name, std::initializer_list<std::size_t> indices, Polynomial& entry) {
    if (entry.size() > max_plain_terms) entry = define(name, index_text(indices, n_), entry);
  }

  void name_tree_terms() {
    D_ = e_.M, D3_ = e_.D, z_ = e_.z;
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = i; j < n_; ++j) {
        name_entry("D", {i, j}, D_[i][j]);
        D_[j][i] = D_[i][j];
      }
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t k = j; k < n_; ++k) {
          name_entry("D", {i, j, k}, D3_[i][j][k]);
          D3_[i][k][j] = D3_[i][j][k];
        }
      name_entry("D", {i}, z_[i]);
    }
  }

  void add_inertia() {
    Matrix DV(n_, Row(n_));
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t s = 0; s < n_; ++s)
        for (std::size_t j = 0; j < n_; ++j) DV[i][s] += D_[i][j] * out_.V[j][s];
    out_.M.assign(n_, Row(n_));
    named_M_ = out_.M;
    for (std::size_t k = 0; k < n_; ++k)
      for (std::size_t s = k; s < n_; ++s) {
        for (std::size_t i = 0; i < n_; ++i) out_.M[k][s] += out_.V[i][k] * DV[i][s];
        out_.M[s][k] = out_.M[k][s];
        Polynomial entry = out_.M[k][s];
        name_entry("M", {k, s}, entry);
        named_M_[k][s] = named_M_[s][k] = entry;
      }
  }

  /// Symmetric coefficients of the tree's rates q̇_j q̇_l in Σ_j Ẇ_ij q̇_j.
  Matrix row_products(std::size_t speed) const {
    Matrix products(columns_, Row(columns_));
    for (std::size_t j = 0; j < columns_; ++j)
      for (std::size_t l = j; l < columns_; ++l) {
        const Polynomial sum = column_derivative(e_.tree, rows_[speed][j], static_cast<int>(l)) +
                               column_derivative(e_.tree, rows_[speed][l], static_cast<int>(j));
        products[j][l] = products[l][j] = Polynomial(Rational(1, 2)) * sum;
      }
    return products;
  }

  /// A quadratic form of q̇ as one of σ.
  Matrix in_speeds(const Matrix& form) const {
    Matrix half(n_, Row(n_)), out(n_, Row(n_));
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t s = 0; s < n_; ++s)
        for (std::size_t l = 0; l < n_; ++l) half[j][s] += form[j][l] * out_.V[l][s];
    for (std::size_t r = 0; r < n_; ++r)
      for (std::size_t s = r; s < n_; ++s) {
        for (std::size_t j = 0; j < n_; ++j) out[r][s] += out_.V[j][r] * half[j][s];
        out[s][r] = out[r][s];
      }
    return out;
  }

  void add_products() {
    for (const int speed : out_.independent) products_.push_back(second_order(static_cast<std::size_t>(speed)));
    for (std::size_t k = 0; k < n_; ++k) {
      Matrix form(n_, Row(n_));
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t l = j; l < n_; ++l) {
          for (std::size_t i = 0; i < n_; ++i)
            form[j][l] += out_.V[i][k] * D3_[i][j][l] - named_M_[k][i] * products_[i][j][l];
          if (reduced_) name_entry("H", {k, j, l}, form[j][l]);
          form[l][j] = form[j][l];
        }
      out_.w.push_back(in_speeds(form));
      out_.z.emplace_back();
      for (std::size_t i = 0; i < n_; ++i) out_.z.back() += out_.V[i][k] * z_[i];
    }
  }

  void add_dependent() {
    for (std::size_t speed = 0; speed < out_.W.size(); ++speed) {
      if (out_.is_independent(speed)) continue;
      Row C(n_);
      for (std::size_t s = 0; s < n_; ++s) {
        for (std::size_t j = 0; j < n_; ++j) C[s] += out_.W[speed][j] * out_.V[j][s];
        if (C[s].size() > max_plain_terms) C[s] = define(out_.C_name, index_text({speed, s}, out_.W.size()), C[s]);
      }
      Matrix form = second_order(speed);
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t l = 0; l < n_; ++l)
          for (std::size_t i = 0; i < n_; ++i) form[j][l] -= C[i] * products_[i][j][l];
      out_.C.push_back(std::move(C));
      out_.c.push_back(in_speeds(form));
    }
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  const ReducedEquations* reduced_;
  std::size_t columns_, n_;  ///< of the tree, and independent ones of them
  SpeedFormulas out_;
  Matrix rows_;                                    ///< speeds × columns of the tree
  std::map<std::string, Polynomial> row_entries_;  ///< symbols, by their names
  std::vector<bool> is_known_;                     ///< per column
  Matrix D_, named_M_;
  std::vector<Matrix> D3_, products_;
  Row z_;
};

}  // namespace

SpeedFormulas derive_speed_formulas(Ring& ring, const SymbolicEquations& equations,
                                    const std::vector<model::GeneralisedSpeed>& speeds,
                                    const ReducedEquations* reduced) {
  return SpeedDerivation(ring, equations, reduced).derive(speeds);
}

bool SpeedFormulas::is_independent(std::size_t speed) const {
  return std::find(independent.begin(), independent.end(), static_cast<int>(speed)) != independent.end();
}

void evaluate_definitions(const SpeedFormulas& formulas, std::vector<double>& symbols,
                          const std::vector<double>& angles) {
  for (const SheetFormula& definition : formulas.definitions)
    symbols[static_cast<std::size_t>(definition.symbol)] = evaluate_formula(definition, symbols, angles);
}

}  // namespace balance::formulas
