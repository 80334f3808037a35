#include "balance/synthesis/formulas/natural_formulas.hpp"

#include "balance/synthesis/formulas/mechanism_symbols.hpp"

#include <array>

namespace balance::formulas {

namespace {

Complex operator+(const Complex& a, const Complex& b) { return {a.re + b.re, a.im + b.im}; }
Complex operator-(const Complex& a, const Complex& b) { return {a.re - b.re, a.im - b.im}; }
Complex operator*(const Complex& a, const Complex& b) { return {a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re}; }
Complex operator*(const Polynomial& a, const Complex& b) { return {a * b.re, a * b.im}; }
Complex conjugate(const Complex& a) { return {a.re, -a.im}; }
Complex planar(const Vector& v) { return {v[0], v[1]}; }
Polynomial inner(const Complex& a, const Complex& b) { return a.re * b.re + a.im * b.im; }
Polynomial outer(const Complex& a, const Complex& b) { return a.re * b.im - a.im * b.re; }

/// "crank1.B" becomes `x_crank1_B`, "link2.(2)" becomes `x_link2_2`.
std::string unknown_name(char axis, const std::string& point) {
  std::string name = std::string(1, axis) + "_";
  for (const char c : point)
    if (c != '(' && c != ')') name += c;
  return identifier_name(name);
}

class NaturalBuilder {
 public:
  NaturalBuilder(Ring& ring, const BasicPointModel& model) : ring_(ring), model_(model) {}

  NaturalEquations build() {
    add_points();
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      const BasicBody& body = model_.bodies[b];
      base_.push_back(base_of(b));
      add_mass_block(b, body.is_triangle ? three_point_mass_block(b) : two_point_mass_block(b));
      add_body_constraints(b);
    }
    for (const BasicJoint& joint : model_.joints) add_joint_constraints(joint);
    for (const Polynomial& row : out_.constraint) {
      out_.jacobian.emplace_back();
      for (const int unknown : out_.unknowns) out_.jacobian.back().push_back(derivative_by_symbol(row, unknown));
    }
    return std::move(out_);
  }

 private:
  using Block = std::vector<std::vector<Complex>>;
  /// Start of a body's base and the vector to its second point, in the body's axes, and 1/length² of the vector.
  struct Base {
    Complex start, base_vector;
    Polynomial inverse;
  };

  void add_points() {
    out_.points = model_.names;
    for (int k = 0; k < model_.moving; ++k)
      for (const char axis : {'x', 'y'})
        out_.unknowns.push_back(
            ring_.add_symbol(unknown_name(axis, model_.names[static_cast<std::size_t>(k)]), SymbolKind::slide, 0));
    for (std::size_t k = 0; k < model_.names.size(); ++k) {
      const std::size_t fixed = k - static_cast<std::size_t>(model_.moving);
      points_.push_back(k < static_cast<std::size_t>(model_.moving)
                            ? Complex{Polynomial::of_symbol(ring_, out_.unknowns[2 * k]),
                                      Polynomial::of_symbol(ring_, out_.unknowns[2 * k + 1])}
                            : planar(model_.fixed[fixed]));
    }
    out_.mass.assign(points_.size(), std::vector<Complex>(points_.size()));
    out_.coefficients.assign(points_.size(), {});
    base_.push_back({});  // the ground needs none
  }

  /// 1/p; a sum gets a name of its own.
  Polynomial inverse(const Polynomial& p, const std::string& name) {
    if (p.is_zero()) throw FormulaError(name + ", a divisor, is zero");
    if (p.size() == 1 && p.terms()[0].wave == 0) return power(p, -1);
    const int symbol = ring_.add_symbol(name, SymbolKind::alias, evaluate_polynomial(p));
    out_.aliases.emplace_back(symbol, p);
    return Polynomial::of_symbol(ring_, symbol, -1);
  }

  Base base_of(std::size_t b) {
    const BasicBody& body = model_.bodies[b];
    const Complex start = planar(body.positions[0]), base_vector = planar(body.positions[1]) - start;
    return {start, base_vector, inverse(inner(base_vector, base_vector), "s" + std::to_string(b))};
  }

  /// Source: P3 eq. 1–5, M = ∫ Nᴴ N dm with N = (1 − κ, κ), κ = (r − a)/(b − a).
  Block two_point_mass_block(std::size_t b) {
    const auto& [mass, moment, inertia] = model_.bodies[b].mass;
    const auto& [a, base_vector, inverse] = base_[b];
    const Complex h = planar(moment);
    const Complex first = inverse * ((h - mass * a) * conjugate(base_vector));
    const Polynomial square = inverse * (inertia[2] - 2 * inner(a, h) + mass * inner(a, a));
    add_coefficient(b, 0, Complex{mass, {}} - first), add_coefficient(b, 1, first);
    const Complex off_diagonal{first.re - square, first.im};
    return {{{mass - 2 * first.re + square, {}}, off_diagonal}, {conjugate(off_diagonal), {square, {}}}};
  }

  /// Source: P3 eq. 6–14 as corrected, with second moments about the CoM that are equal in all directions.
  Block three_point_mass_block(std::size_t b) {
    const auto& [mass, moment, inertia] = model_.bodies[b].mass;
    const Polynomial& x = moment[0];
    const Polynomial& y = moment[1];
    const Polynomial inverse_mass = mass.is_zero() ? Polynomial() : inverse(mass, "mt" + std::to_string(b));
    const Polynomial half = Polynomial(Rational(1, 2)) * (inertia[2] - inverse_mass * (x * x + y * y));
    const Matrix S{{mass, x, y},
                   {x, half + inverse_mass * x * x, inverse_mass * x * y},
                   {y, inverse_mass * x * y, half + inverse_mass * y * y}};
    std::array<Complex, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = planar(model_.bodies[b].positions[k]);
    const Polynomial area = inverse(outer(corner[1] - corner[0], corner[2] - corner[0]), "Delta" + std::to_string(b));
    Matrix weight;  // row k: λ_k = weight · (1, x, y)
    for (std::size_t k = 0; k < 3; ++k) {
      const Complex &next = corner[(k + 1) % 3], &last = corner[(k + 2) % 3];
      weight.push_back({area * outer(next, last), area * (next.im - last.im), area * (last.re - next.re)});
      add_coefficient(b, k,
                      {area * (mass * outer(next, last) + x * (next.im - last.im) + y * (last.re - next.re)), {}});
    }
    Block block(3, std::vector<Complex>(3));
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t l = 0; l < 3; ++l) block[i][j].re += weight[i][k] * S[k][l] * weight[j][l];
    return block;
  }

  /// Adds to C_P, ∫ N dm over all bodies at P (P3 eq. 37): the sums of the mass matrix's columns in a shorter form.
  void add_coefficient(std::size_t b, std::size_t k, const Complex& coefficient) {
    Complex& sum = out_.coefficients[static_cast<std::size_t>(model_.bodies[b].points[k])];
    sum = sum + coefficient;
  }

  void add_mass_block(std::size_t b, const Block& block) {
    for (std::size_t i = 0; i < block.size(); ++i)
      for (std::size_t j = 0; j < block.size(); ++j) {
        const auto row = static_cast<std::size_t>(model_.bodies[b].points[i]);
        const auto column = static_cast<std::size_t>(model_.bodies[b].points[j]);
        out_.mass[row][column] = out_.mass[row][column] + block[i][j];
      }
  }

  const Complex& point(std::size_t b, std::size_t k) const {
    return points_[static_cast<std::size_t>(model_.bodies[b].points[k])];
  }

  /// Direction of the body's x axis in the world.
  Complex direction(std::size_t b) const {
    if (b == model::ground) return {1, {}};
    return base_[b].inverse * ((point(b, 1) - point(b, 0)) * conjugate(base_[b].base_vector));
  }
  Complex position_of(std::size_t b, const Complex& r) const {
    if (b == model::ground) return r;
    return point(b, 0) + (r - base_[b].start) * direction(b);
  }

  void add_constraint(Polynomial row) {
    if (row.size() > 0) out_.constraint.push_back(std::move(row));
  }

  void add_distance_constraint(std::size_t b, std::size_t i, std::size_t j) {
    const Complex world_vector = point(b, j) - point(b, i);
    const Complex body_vector = planar(model_.bodies[b].positions[j]) - planar(model_.bodies[b].positions[i]);
    if (model_.bodies[b].points[i] < model_.moving || model_.bodies[b].points[j] < model_.moving)
      add_constraint(inner(world_vector, world_vector) - inner(body_vector, body_vector));
  }

  /// Distances between the corners; the other points of the body follow its base.
  void add_body_constraints(std::size_t b) {
    const BasicBody& body = model_.bodies[b];
    add_distance_constraint(b, 0, 1);
    if (body.is_triangle) add_distance_constraint(b, 0, 2), add_distance_constraint(b, 1, 2);
    for (std::size_t k = body.is_triangle ? 3 : 2; k < body.points.size(); ++k) {
      const Complex residual = point(b, k) - position_of(b, planar(body.positions[k]));
      add_constraint(residual.re), add_constraint(residual.im);
    }
  }

  void add_joint_constraints(const BasicJoint& joint) {
    const auto first = static_cast<std::size_t>(joint.first), second = static_cast<std::size_t>(joint.second);
    if (joint.type != JointType::pin_slot)
      add_constraint(outer(planar(joint.rotation) * direction(first), direction(second)));
    if (joint.type != JointType::fixed)
      add_constraint(outer(planar(joint.axis) * direction(first),
                           position_of(second, planar(joint.q)) - position_of(first, planar(joint.p))));
  }

  Ring& ring_;
  const BasicPointModel& model_;
  NaturalEquations out_;
  std::vector<Complex> points_;
  std::vector<Base> base_;  ///< per body
};

}  // namespace

NaturalEquations derive_natural_equations(Ring& ring, const BasicPointModel& model) {
  return NaturalBuilder(ring, model).build();
}

}  // namespace balance::formulas
