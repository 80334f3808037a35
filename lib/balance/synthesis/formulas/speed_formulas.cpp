#include "balance/synthesis/formulas/speed_formulas.hpp"

#include "balance/foundation/numerics/eigen_instantiations.hpp"
#include "balance/synthesis/formulas/closure_elimination.hpp"
#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/formulas/symbolic_recursion.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <random>

namespace balance::formulas {

namespace {

/// More speeds that depend on each other are not solved for: the determinant becomes too long.
constexpr std::size_t max_solved_speeds = 4;
/// Longer entries get names where they occur in others.
constexpr std::size_t max_plain_terms = 2;
constexpr double min_relative_pivot = 1e-6;  // of speeds that determine the motion, at a random pose

/// Numbers as fractions or, if they are no short decimals, as symbols: one for equal numbers.
class NumberSymbols {
 public:
  explicit NumberSymbols(Ring& ring) : ring_(ring) {}

  Polynomial polynomial(double value) {
    if (value == 0) return {};
    Rational decimal;
    if (find_decimal(value, decimal)) return {decimal};
    const auto [known, is_new] = symbols_.try_emplace(value, -1);
    if (is_new) known->second = ring_.add_symbol("f", SymbolKind::dimensionless, value);
    return Polynomial::of_symbol(ring_, known->second);
  }

 private:
  Ring& ring_;
  std::map<double, int> symbols_;
};

// Factors that depend on the pose: expressions of joint coordinates.

/// A polynomial, or Σ multiple · angle, which only sines and cosines take.
struct FactorValue {
  Polynomial polynomial;
  std::map<int, int> angles;  ///< multiples by angle of the ring; empty: a polynomial

  const Polynomial& plain() const {
    if (!angles.empty())
      throw FormulaError("a factor of a speed contains an angle outside sin and cos, which has no formula here");
    return polynomial;
  }
};

struct FactorAlgebra {
  using Value = FactorValue;
  Ring& ring;
  NumberSymbols& numbers;

  Value constant(double value) const { return {numbers.polynomial(value), {}}; }

  Value apply(const expression::ExpressionNode& node, const Value& a, const Value& b, const Value& /*third*/) const {
    using expression::Operation;
    switch (node.operation) {
      case Operation::alias: return a;
      case Operation::add: return sum(a, b, 1);
      case Operation::subtract: return sum(a, b, -1);
      case Operation::negate: return sum({}, a, -1);
      case Operation::multiply: return product(a, b);
      case Operation::divide: return product(a, {power(b.plain(), -1), {}});
      case Operation::power: return {power(a.plain(), whole_number(b)), {}};
      case Operation::function: return circular(node, a);
      default: throw FormulaError("a factor of a speed contains a comparison or a branch, which has no formula here");
    }
  }

 private:
  static Value sum(const Value& a, const Value& b, int sign) {
    if (a.angles.empty() && b.angles.empty())
      return {sign > 0 ? a.polynomial + b.polynomial : a.polynomial - b.polynomial, {}};
    if ((a.angles.empty() && !a.polynomial.is_zero()) || (b.angles.empty() && !b.polynomial.is_zero()))
      throw FormulaError("a factor of a speed adds a number to an angle, which has no formula here");
    Value out{{}, a.angles};
    for (const auto& [angle, multiple] : b.angles) out.angles[angle] += sign * multiple;
    return out;
  }
  static Value product(const Value& a, const Value& b) {
    if (!b.angles.empty()) return product(b, a);
    if (a.angles.empty()) return {a.polynomial * b.polynomial, {}};
    Value out = a;
    const int multiple = whole_number(b);
    for (auto& [angle, own] : out.angles) own *= multiple;
    return out;
  }
  static int whole_number(const Value& value) {
    const std::vector<Term>& terms = value.plain().terms();
    if (terms.empty()) return 0;
    if (terms.size() == 1 && terms[0].monomial.is_one() && terms[0].wave == 0 && terms[0].coefficient.is_integer() &&
        std::abs(terms[0].coefficient.value()) < 16)
      return static_cast<int>(terms[0].coefficient.numerator());
    throw FormulaError("a factor of a speed contains a multiple of an angle or a power that is not whole");
  }
  Value circular(const expression::ExpressionNode& node, const Value& a) const {
    const std::string name(expression::list_unary_functions()[static_cast<std::size_t>(node.function)].name);
    if ((name != "sin" && name != "cos") || (a.angles.empty() && !a.polynomial.is_zero()))
      throw FormulaError("a factor of a speed contains " + name + "(…), which has no formula here");
    Polynomial cosine(1), sine;
    for (const auto& [angle, multiple] : a.angles)
      for (int k = 0; k < std::abs(multiple); ++k) {
        const Polynomial c = Polynomial::of_angle(ring, angle, false),
                         s = multiple > 0 ? Polynomial::of_angle(ring, angle, true)
                                          : -Polynomial::of_angle(ring, angle, true);
        const Polynomial next = cosine * c - sine * s;
        sine = sine * c + cosine * s;
        cosine = next;
      }
    return {name == "cos" ? cosine : sine, {}};
  }
};

// The rows of W.

class SpeedRows {
 public:
  SpeedRows(Ring& ring, const SymbolicEquations& equations, SpeedFormulas& out)
      : ring_(ring), numbers_(ring), e_(equations), make_{ring}, n_(equations.tree.columns.size()), out_(out) {}

  Row of(const model::GeneralisedSpeed& speed) {
    Row sum(n_);
    for (const model::GeneralisedSpeedTerm& term : speed.terms) {
      Polynomial factor = numbers_.polynomial(term.factor);
      if (term.pose_factor) factor = factor * pose_factor(term);
      const Row row = of(term);
      for (std::size_t j = 0; j < n_; ++j) sum[j] += factor * row[j];
    }
    return sum;
  }

 private:
  Row of(const model::GeneralisedSpeedTerm& term) {
    using enum model::GeneralisedSpeedTerm::Kind;
    switch (term.kind) {
      case coordinate: return coordinate_row(term.index);
      case com_velocity: return com_row(static_cast<std::size_t>(term.index));
      case velocity:
      case velocity_body: return velocity_row(term);
      case angular_velocity:
      case angular_velocity_body: return angular_row(term);
    }
    return {};
  }

  const JointVariable& variable(int coordinate) const {
    const int index = e_.tree.coordinate_variable[static_cast<std::size_t>(coordinate)];
    if (index < 0) throw FormulaError("a speed contains a coordinate of a joint that closes a loop");
    return e_.tree.variables[static_cast<std::size_t>(index)];
  }

  Row coordinate_row(int coordinate) const {
    Row row(n_);
    for (const auto& [column, ratio] : variable(coordinate).follows) row[static_cast<std::size_t>(column)] += ratio;
    return row;
  }

  /// The total mass is a divisor and therefore a symbol.
  Row com_row(std::size_t axis) {
    if (mass_ < 0) {
      out_.definitions.push_back(define_formula(ring_, "mt", "", e_.mass));
      mass_ = out_.definitions.back().symbol;
    }
    Row row;
    for (std::size_t j = 0; j < n_; ++j)
      row.push_back(Polynomial::of_symbol(ring_, mass_, -1) *
                    column_derivative(e_.tree, e_.moment[axis], static_cast<int>(j)));
    return row;
  }

  Row velocity_row(const model::GeneralisedSpeedTerm& term) {
    FramePoint point = e_.tree.bodies[static_cast<std::size_t>(term.body)];
    point.at = point.at + place_on(term);
    const Vector p = world_position<Polynomial>(e_.tree, make_, point);
    Row row;
    for (std::size_t j = 0; j < n_; ++j) {
      Vector v;
      for (std::size_t k = 0; k < 3; ++k) v[k] = column_derivative(e_.tree, p[k], static_cast<int>(j));
      row.push_back(component(term, point.frame, v));
    }
    return row;
  }

  Row angular_row(const model::GeneralisedSpeedTerm& term) {
    const int frame = e_.tree.bodies[static_cast<std::size_t>(term.body)].frame;
    std::vector<Vector> w(n_);
    for (int f = frame; f > 0; f = e_.tree.frames[static_cast<std::size_t>(f)].parent) {
      const SymbolicFrame& at = e_.tree.frames[static_cast<std::size_t>(f)];
      if (at.variable < 0 || at.angle < 0) continue;
      const Vector axis = world_direction<Polynomial>(e_.tree, make_, f, at.axis);
      for (const auto& [column, ratio] : e_.tree.variables[static_cast<std::size_t>(at.variable)].follows)
        w[static_cast<std::size_t>(column)] =
            w[static_cast<std::size_t>(column)] + scale_vector(at.sign > 0 ? ratio : -ratio, axis);
    }
    Row row;
    for (const Vector& one : w) row.push_back(component(term, frame, one));
    return row;
  }

  Polynomial component(const model::GeneralisedSpeedTerm& term, int frame, const Vector& v) {
    using enum model::GeneralisedSpeedTerm::Kind;
    const bool is_in_body_axes = term.kind == velocity_body || term.kind == angular_velocity_body;
    return is_in_body_axes ? dot(world_direction<Polynomial>(e_.tree, make_, frame, term.index), v)
                           : v[static_cast<std::size_t>(term.index)];
  }

  /// The position on the body: a named point's, or numbers.
  Vector place_on(const model::GeneralisedSpeedTerm& term) {
    const auto& points = e_.tree.model->mechanism().bodies[static_cast<std::size_t>(term.body)].points;
    for (const auto& point : points)
      if (!term.position.isZero(0) && to_values(point.position) == term.position)
        return e_.tree.numbers->body_point(term.body, point.name);
    return {numbers_.polynomial(term.position[0]), numbers_.polynomial(term.position[1]),
            numbers_.polynomial(term.position[2])};
  }

  Polynomial pose_factor(const model::GeneralisedSpeedTerm& term) {
    std::vector<FactorValue> inputs;
    for (const CoordinateId c : term.pose_variables) {
      const JointVariable& joint = variable(c);
      if (joint.index < 0) throw FormulaError("a factor of a speed contains a coordinate that does not move");
      if (joint.is_angle)
        inputs.push_back({{}, {{joint.index, 1}}});
      else
        inputs.push_back({Polynomial::of_symbol(ring_, joint.index), {}});
    }
    for (const double parameter : term.pose_factor.parameters) inputs.push_back({numbers_.polynomial(parameter), {}});
    const std::vector<FactorValue> values =
        expression::evaluate(*term.pose_factor.graph, inputs, FactorAlgebra{ring_, numbers_});
    return values[static_cast<std::size_t>(term.pose_factor.node)].plain();
  }

  Ring& ring_;
  NumberSymbols numbers_;
  const SymbolicEquations& e_;
  PolynomialFactory make_;
  std::size_t n_;
  SpeedFormulas& out_;
  int mass_ = -1;
};

class SpeedDerivation {
 public:
  SpeedDerivation(Ring& ring, const SymbolicEquations& equations)
      : ring_(ring), e_(equations), n_(equations.tree.columns.size()) {}

  SpeedFormulas derive(const std::vector<model::GeneralisedSpeed>& speeds) {
    SpeedRows rows(ring_, e_, out_);
    for (const model::GeneralisedSpeed& speed : speeds) {
      out_.names.push_back(speed.name);
      out_.W.push_back(rows.of(speed));
    }
    choose_independent();
    solve();
    name_tree_terms();
    add_inertia();
    add_products();
    add_dependent();
    return std::move(out_);
  }

 private:
  const Polynomial& W(std::size_t i, std::size_t j) const {
    return out_.W[static_cast<std::size_t>(out_.independent[i])][j];
  }

  /// The first speeds that determine the motion, at a random pose and with the spec's numbers.
  void choose_independent() {
    std::vector<double> symbols, angles;
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (const Symbol& symbol : ring_.symbols())
      symbols.push_back(symbol.kind == SymbolKind::slide ? uniform(random) : symbol.value);
    for (const Angle& angle : ring_.angles()) angles.push_back(angle.is_fixed ? angle.value : 3 * uniform(random));
    evaluate_definitions(out_, symbols, angles);
    MatrixX taken(0, static_cast<Eigen::Index>(n_));
    for (std::size_t i = 0; i < out_.W.size() && out_.independent.size() < n_; ++i) {
      MatrixX next(taken.rows() + 1, taken.cols());
      next.topRows(taken.rows()) = taken;
      for (std::size_t j = 0; j < n_; ++j)
        next(taken.rows(), static_cast<Eigen::Index>(j)) = evaluate_polynomial(out_.W[i][j], symbols, angles);
      next.row(taken.rows()).stableNormalize();
      const VectorX values = numerics::singular_values(next);
      if (!(values[values.size() - 1] > min_relative_pivot * values[0])) continue;
      taken = next;
      out_.independent.push_back(static_cast<int>(i));
    }
    if (out_.independent.size() < n_)
      throw FormulaError("the speeds do not determine the motion: " + std::to_string(n_) +
                         " that are independent are needed");
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
      define("Delta", "", det);
      divisor = out_.definitions.back().label();
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

  /// Symmetric coefficients of q̇_j q̇_l in Σ_j Ẇ_ij q̇_j.
  Matrix row_products(std::size_t speed) const {
    Matrix products(n_, Row(n_));
    for (std::size_t j = 0; j < n_; ++j)
      for (std::size_t l = j; l < n_; ++l) {
        const Polynomial sum = column_derivative(e_.tree, out_.W[speed][j], static_cast<int>(l)) +
                               column_derivative(e_.tree, out_.W[speed][l], static_cast<int>(j));
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
    for (const int speed : out_.independent) products_.push_back(row_products(static_cast<std::size_t>(speed)));
    for (std::size_t k = 0; k < n_; ++k) {
      Matrix form(n_, Row(n_));
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t l = j; l < n_; ++l) {
          for (std::size_t i = 0; i < n_; ++i)
            form[j][l] += out_.V[i][k] * D3_[i][j][l] - named_M_[k][i] * products_[i][j][l];
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
        if (C[s].size() > max_plain_terms) C[s] = define("C", index_text({speed, s}, out_.W.size()), C[s]);
      }
      Matrix form = row_products(speed);
      for (std::size_t j = 0; j < n_; ++j)
        for (std::size_t l = 0; l < n_; ++l)
          for (std::size_t i = 0; i < n_; ++i) form[j][l] -= C[i] * products_[i][j][l];
      out_.C.push_back(std::move(C));
      out_.c.push_back(in_speeds(form));
    }
  }

  Ring& ring_;
  const SymbolicEquations& e_;
  std::size_t n_;
  SpeedFormulas out_;
  std::vector<bool> is_known_;  ///< per column
  Matrix D_, named_M_;
  std::vector<Matrix> D3_, products_;
  Row z_;
};

}  // namespace

SpeedFormulas derive_speed_formulas(Ring& ring, const SymbolicEquations& equations,
                                    const std::vector<model::GeneralisedSpeed>& speeds) {
  if (!equations.tree.closures.empty())
    throw FormulaError("formulas in chosen speeds are for mechanisms without loops; --at has their numbers at a pose");
  return SpeedDerivation(ring, equations).derive(speeds);
}

bool SpeedFormulas::is_independent(std::size_t speed) const {
  return std::find(independent.begin(), independent.end(), static_cast<int>(speed)) != independent.end();
}

void evaluate_definitions(const SpeedFormulas& formulas, std::vector<double>& symbols,
                          const std::vector<double>& angles) {
  for (const SheetFormula& definition : formulas.definitions)
    symbols[static_cast<std::size_t>(definition.symbol)] = evaluate_polynomial(definition.value, symbols, angles) /
                                                           evaluate_polynomial(definition.denominator, symbols, angles);
}

}  // namespace balance::formulas
