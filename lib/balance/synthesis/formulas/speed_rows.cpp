#include "balance/synthesis/formulas/speed_rows.hpp"

#include "balance/synthesis/formulas/mechanism_symbols.hpp"
#include "balance/synthesis/formulas/symbolic_recursion.hpp"

#include <cmath>
#include <map>

namespace balance::formulas {

namespace {

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

class RowDerivation {
 public:
  RowDerivation(Ring& ring, const SymbolicEquations& equations, SpeedRows& out)
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
  SpeedRows& out_;
  int mass_ = -1;
};

}  // namespace

SpeedRows derive_speed_rows(Ring& ring, const SymbolicEquations& equations,
                            const std::vector<model::GeneralisedSpeed>& speeds) {
  SpeedRows out;
  RowDerivation derivation(ring, equations, out);
  for (const model::GeneralisedSpeed& speed : speeds) out.rows.push_back(derivation.of(speed));
  return out;
}

}  // namespace balance::formulas
