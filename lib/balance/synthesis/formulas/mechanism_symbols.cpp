#include "balance/synthesis/formulas/mechanism_symbols.hpp"

#include "balance/foundation/expression/expression_parser.hpp"
#include "balance/synthesis/formulas/formula_parser.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <utility>

namespace balance::formulas {

namespace {

constexpr const char* axis_letters[] = {"x", "y", "z"};
/// Entry of a symmetric matrix: row, column, name.
struct Entry {
  int row, column;
  const char* name;
};
constexpr Entry inertia_entries[] = {{0, 0, "x"}, {1, 1, "y"}, {2, 2, "z"}, {0, 1, "xy"}, {0, 2, "xz"}, {1, 2, "yz"}};

std::string item(const std::string& path, int k) { return path.empty() ? "" : path + "[" + std::to_string(k) + "]"; }
std::string name_suffix(const std::string& name) { return "_" + name; }

}  // namespace

MechanismSymbols::MechanismSymbols(Ring& ring, const ParametricModel& model, const study::SpecNumberTexts& texts,
                                   const TreeOptions& options)
    : spec_symbols_(ring, model, texts, options),
      mechanism_(model.mechanism()),
      model_(model),
      texts_(texts),
      ring_(ring),
      is_about_origin_(options.inertial == InertialParametrisation::about_origin) {}

int MechanismSymbols::count_nonzero(const Vector3E& v) const {
  return static_cast<int>(std::count_if(v.begin(), v.end(), [&](const Expression& x) { return !model_.is_zero(x); }));
}

/// The named point to which the spec refers, unless the position was moved since (a rolling body is held at its
/// centre).
const model::NamedPointOf<Expression>* MechanismSymbols::named_point(const std::string& path, int body,
                                                                     const Vector3E& position) const {
  const auto text = texts_.numbers.find(path);
  if (text == texts_.numbers.end()) return nullptr;
  const auto& owner = mechanism_.bodies[static_cast<std::size_t>(body)];
  for (const NamedPointE& point : owner.points)
    if ((text->second == point.name || text->second == owner.name + "." + point.name) &&
        model_.are_equal(point.position, position))
      return &point;
  return nullptr;
}

/// @param single_name name of the only nonzero coordinate
/// @param suffix of x, y, z if several are nonzero
Vector MechanismSymbols::position(const std::string& path, const Vector3E& position, const std::string& single_name,
                                  const std::string& suffix, SymbolKind kind) {
  Vector vector;
  const bool has_single_coordinate = count_nonzero(position) == 1 && !single_name.empty();
  for (int k = 0; k < 3; ++k)
    vector[static_cast<std::size_t>(k)] = spec_symbols_.polynomial_at(
        item(path, k), position[k], has_single_coordinate ? single_name : axis_letters[k] + suffix, kind);
  return vector;
}

Vector MechanismSymbols::unnamed_point(const std::string& path, int body, const Vector3E& position,
                                       const std::string& name) {
  const auto [entry, is_new] = points_.try_emplace(path);
  if (!is_new) return entry->second;
  const std::string number = body == model::ground ? "" : std::to_string(body);
  std::string single_name;
  if (body != model::ground && count_nonzero(position) == 1 && bodies_with_length_.insert(body).second)
    single_name = "l" + number;
  return entry->second = this->position(path, position, single_name, name + number, SymbolKind::length);
}

Vector MechanismSymbols::referenced_point(const std::string& path, int body, const Vector3E& position) {
  const auto& owner = mechanism_.bodies[static_cast<std::size_t>(body)];
  const NamedPointE* named = named_point(path, body, position);
  if (named == nullptr) return unnamed_point(path, body, position, "P");
  const std::string section = body == model::ground ? "ground" : "bodies." + owner.name;
  return unnamed_point(section + ".points." + named->name, body, position, named->name);
}

Vector MechanismSymbols::joint_point(int index, bool first) {
  const auto& joint = mechanism_.joints[static_cast<std::size_t>(index)];
  return referenced_point("joints." + joint.name + (first ? ".connects[0]" : ".connects[1]"),
                          first ? joint.first : joint.second, first ? joint.point_first : joint.point_second);
}

Vector MechanismSymbols::spring_point(std::size_t index, bool first) {
  const auto& spring = mechanism_.springs[index];
  return referenced_point("springs." + spring.name + (first ? ".between[0]" : ".between[1]"),
                          first ? spring.first : spring.second, first ? spring.point_first : spring.point_second);
}

Vector MechanismSymbols::tool_point() {
  if (!mechanism_.tool) return {};
  return referenced_point("tool", mechanism_.tool->body, mechanism_.tool->position);
}

Vector MechanismSymbols::body_point(int body, const std::string& name) {
  const auto& owner = mechanism_.bodies[static_cast<std::size_t>(body)];
  for (const NamedPointE& point : owner.points)
    if (point.name == name)
      return unnamed_point((body == model::ground ? "ground" : "bodies." + owner.name) + ".points." + name, body,
                           point.position, name);
  return {};
}

RingSymmetric3<Polynomial> MechanismSymbols::inertia(const MassText& text) {
  RingSymmetric3<Polynomial> J;
  for (int k = 0; k < 6; ++k) {
    if (planar() && k != 2) continue;
    const auto [row, column, name] = inertia_entries[k];
    const std::string path = planar() ? text.path + ".inertia" : item(text.path + ".inertia", k);
    J[static_cast<std::size_t>(k)] = spec_symbols_.polynomial_at(
        path, text.inertia(row, column), std::string("J") + name + text.name, SymbolKind::inertia);
  }
  return J;
}

Mass MechanismSymbols::about_com(const Polynomial& mass, const Vector& com, const MassText& text) {
  Mass mass_properties;
  mass_properties.mass = mass;
  mass_properties.inertia = inertia(text);
  return shift_origin(mass_properties, com);
}

Mass MechanismSymbols::about_origin(const std::string& name, const Expression& mass, const Vector3E& com,
                                    const Matrix3E& inertia) {
  Mass mass_properties;
  const auto symbol = [&](const std::string& letter, const Expression& value, SymbolKind kind) {
    inertial_.push_back(ring_.add_symbol(identifier_name(letter + name), kind, value));
    return Polynomial::of_symbol(ring_, inertial_.back());
  };
  const Vector3E h = mass * com;
  Matrix3E I = inertia;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) I(i, j) += mass * ((i == j ? com.squaredNorm() : Expression(0)) - com[i] * com[j]);
  mass_properties.mass = symbol("m", mass, SymbolKind::mass);
  for (int k = 0; k < (planar() ? 2 : 3); ++k)
    mass_properties.moment[static_cast<std::size_t>(k)] =
        symbol(std::string("m") + axis_letters[k], h[k], SymbolKind::first_moment);
  if (planar()) {
    mass_properties.inertia[2] = symbol("J", I(2, 2), SymbolKind::inertia);
    return mass_properties;
  }
  for (int k = 0; k < 6; ++k) {
    const auto [row, column, axes] = inertia_entries[k];
    const std::string axis_pair = k < 3 ? std::string(axes) + axes : axes;
    mass_properties.inertia[static_cast<std::size_t>(k)] = symbol("I" + axis_pair, I(row, column), SymbolKind::inertia);
  }
  return mass_properties;
}

Mass MechanismSymbols::body(int index) {
  const auto& body = mechanism_.bodies[static_cast<std::size_t>(index)];
  const std::string number = std::to_string(index), path = "bodies." + body.name;
  if (is_about_origin_) return about_origin(number, body.mass, body.com, body.inertia);
  const Polynomial mass = spec_symbols_.polynomial_at(path + ".mass", body.mass, "m" + number, SymbolKind::mass);
  const Vector com = position(path + ".com", body.com, "lg" + number, "g" + number, SymbolKind::com_coordinate);
  return about_com(mass, com, {path, number, body.inertia});
}

/// Its own numbers, or a named point of the body that carries it.
Vector MechanismSymbols::attachment_position(const std::string& path, int body, const Vector3E& position,
                                             const std::string& name) {
  if (named_point(path + ".at", body, position) != nullptr) return referenced_point(path + ".at", body, position);
  return this->position(path + ".at", position, "", name, SymbolKind::com_coordinate);
}

Vector MechanismSymbols::disc_position(int index) {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  return attachment_position("discs." + disc.name, disc.body, disc.position, name_suffix(disc.name));
}

Mass MechanismSymbols::attachment(int index) {
  const auto& element = mechanism_.attachments[static_cast<std::size_t>(index)];
  const bool is_payload = element.kind == AttachmentKind::payload;
  const std::string path = (is_payload ? "payloads." : "counterweights.") + element.name,
                    name = name_suffix(element.name);
  if (is_about_origin_) return about_origin(name, element.mass, element.position, element.inertia);
  const Polynomial mass = spec_symbols_.polynomial_at(path + ".mass", element.mass, "m" + name, SymbolKind::mass);
  return about_com(mass, attachment_position(path, element.body, element.position, name),
                   {path, name, element.inertia});
}

Mass MechanismSymbols::disc(int index) {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  const std::string path = "discs." + disc.name, name = name_suffix(disc.name);
  if (is_about_origin_) return about_origin(name, disc.mass, Vector3E::Zero(), disc.inertia);
  return about_com(spec_symbols_.polynomial_at(path + ".mass", disc.mass, "m" + name, SymbolKind::mass), {},
                   {path, name, disc.inertia});
}

bool MechanismSymbols::is_rotor(int index) const {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  return !planar() && !is_about_origin_ && texts_.numbers.contains("discs." + disc.name + ".inertia.axial");
}

Mass MechanismSymbols::rotor(int index, int axis) {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  const std::string path = "discs." + disc.name, name = name_suffix(disc.name);
  const Vector3E& u = disc.axis;
  const Expression axial = u.dot(disc.inertia * u);
  const Expression transverse = (disc.inertia(0, 0) + disc.inertia(1, 1) + disc.inertia(2, 2) - axial) / 2;
  Mass mass_properties;
  mass_properties.mass = spec_symbols_.polynomial_at(path + ".mass", disc.mass, "m" + name, SymbolKind::mass);
  for (int k = 0; k < 3; ++k)
    mass_properties.inertia[static_cast<std::size_t>(k)] =
        k == axis
            ? spec_symbols_.polynomial_at(path + ".inertia.axial", axial, "Ja" + name, SymbolKind::inertia)
            : spec_symbols_.polynomial_at(path + ".inertia.transverse", transverse, "Jt" + name, SymbolKind::inertia);
  return mass_properties;
}

/// Whether the spec states it without a parameter: a constant, or an input of its own.
bool MechanismSymbols::is_plain_number(const Expression& x) const {
  if (x.is_constant()) return true;
  const int input = model_.input_of(x).index;
  const auto& parameters = model_.parameters();
  return input >= 0 && std::none_of(parameters.begin(), parameters.end(), [&](const study::NamedExpression& one) {
           return model_.input_of(one.value).index == input;
         });
}

Vector MechanismSymbols::gravity() {
  const Vector3E& g = mechanism_.gravity;
  Vector vector;
  for (int k = 0; k < 3; ++k) {
    const bool is_alone = count_nonzero(g) == 1 && !model_.is_zero(g[k]);
    const std::string name = is_alone ? "g" : std::string("g") + axis_letters[k], path = item("gravity", k);
    vector[static_cast<std::size_t>(k)] =
        g[k].value() < 0 && is_plain_number(g[k])  // the symbol g is positive
            ? spec_symbols_.opposite_polynomial_at(path, g[k], name, SymbolKind::gravity)
            : spec_symbols_.polynomial_at(path, g[k], name, SymbolKind::gravity);
  }
  return vector;
}

Polynomial MechanismSymbols::ratio(int index) {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  return spec_symbols_.polynomial_at("discs." + disc.name + ".ratio", disc.ratio, "n_" + disc.name, SymbolKind::ratio);
}

/// The joint of a wheel that rolls along a line, which is a coupling that the spec does not state; null for others.
const model::JointOf<Expression>* MechanismSymbols::wheel_of(std::size_t c) const {
  const std::string path = "couplings[" + std::to_string(c) + "]";
  const auto stated = texts_.numbers.lower_bound(path);
  if (stated != texts_.numbers.end() && stated->first.starts_with(path)) return nullptr;
  const Coordinate& follower = mechanism_.coordinates[static_cast<std::size_t>(mechanism_.couplings[c].follower)];
  const auto& joint = mechanism_.joints[static_cast<std::size_t>(follower.joint)];
  return texts_.numbers.contains("joints." + joint.name + ".radius") ? &joint : nullptr;
}

Polynomial MechanismSymbols::coupling_ratio(std::size_t c) {
  if (const auto* wheel = wheel_of(c))
    return -spec_symbols_.polynomial_at("joints." + wheel->name + ".radius", -mechanism_.couplings[c].ratio,
                                        "r_" + wheel->name, SymbolKind::length);
  return spec_symbols_.polynomial_at("couplings[" + std::to_string(c) + "].ratio", mechanism_.couplings[c].ratio,
                                     "n" + std::to_string(c + 1), SymbolKind::ratio);
}

Polynomial MechanismSymbols::coupling_offset(std::size_t c) {
  return spec_symbols_.polynomial_at("couplings[" + std::to_string(c) + "].offset", mechanism_.couplings[c].offset,
                                     "o" + std::to_string(c + 1), SymbolKind::dimensionless);
}

Polynomial MechanismSymbols::disc_term(int index, std::size_t k) {
  const auto& disc = mechanism_.discs[static_cast<std::size_t>(index)];
  const auto& term = disc.follows.terms[k];
  const std::string& leader = mechanism_.coordinates[static_cast<std::size_t>(term.coordinate)].name;
  return spec_symbols_.polynomial_at("discs." + disc.name + ".follows." + leader, term.ratio,
                                     "n_" + disc.name + "_" + leader, SymbolKind::ratio);
}

Polynomial MechanismSymbols::coupling_term(std::size_t c, std::size_t k) {
  const auto& term = mechanism_.couplings[c].leader.terms[k];
  const std::string& leader = mechanism_.coordinates[static_cast<std::size_t>(term.coordinate)].name;
  return spec_symbols_.polynomial_at("couplings[" + std::to_string(c) + "].follows." + leader, term.ratio,
                                     "n" + std::to_string(c + 1) + "_" + leader, SymbolKind::ratio);
}

Polynomial MechanismSymbols::stiffness(std::size_t s) {
  const auto& spring = mechanism_.springs[s];
  return spec_symbols_.polynomial_at("springs." + spring.name + ".stiffness", spring.stiffness, "k_" + spring.name,
                                     SymbolKind::stiffness);
}

Polynomial MechanismSymbols::free_length(std::size_t s) {
  const auto& spring = mechanism_.springs[s];
  return spec_symbols_.polynomial_at("springs." + spring.name + ".free_length", spring.free_length, "l0_" + spring.name,
                                     SymbolKind::length);
}

/// As in the spec: directly, or by the coordinate at which the spring is at rest.
Polynomial MechanismSymbols::preload(std::size_t s) {
  const auto& spring = mechanism_.springs[s];
  const std::string path = "springs." + spring.name;
  if (!texts_.numbers.contains(path + ".rest"))
    return spec_symbols_.polynomial_at(path + ".preload", spring.preload, "p_" + spring.name, SymbolKind::stiffness);
  if (model_.is_zero(spring.preload)) return {};
  // with zero stiffness, take the rest at the perturbed numbers
  const Expression rest = select(equal(spring.stiffness, 0),
                                 model_.perturbed_value(spring.preload) / model_.perturbed_value(spring.stiffness),
                                 spring.preload / spring.stiffness);
  return stiffness(s) *
         spec_symbols_.polynomial_at(path + ".rest", rest, "q0_" + spring.name, SymbolKind::com_coordinate);
}

Polynomial MechanismSymbols::joint_radius(int index) {
  const auto& joint = mechanism_.joints[static_cast<std::size_t>(index)];
  return spec_symbols_.polynomial_at("joints." + joint.name + ".radius", joint.radius, "r_" + joint.name,
                                     SymbolKind::length);
}

Vector MechanismSymbols::wheel_centre_offset(int index) {
  const auto& joint = mechanism_.joints[static_cast<std::size_t>(index)];
  const Polynomial r = joint_radius(index);
  Vector offset;
  for (int k = 0; k < 3; ++k) {
    if (model_.is_zero(joint.axis[k])) continue;
    const double component = joint.axis[k].value();
    if (!joint.axis[k].is_constant() || std::abs(component) != 1)
      throw FormulaError("joint " + joint.name + " rolls on a plane that is not perpendicular to an axis of its body");
    offset[static_cast<std::size_t>(k)] = component > 0 ? r : -r;
  }
  return offset;
}

std::string MechanismSymbols::coordinate_name(int index) const {
  const Coordinate& coordinate = mechanism_.coordinates[static_cast<std::size_t>(index)];
  const std::string& name = coordinate.name;
  const bool is_numbered = name.size() > 1 && name[0] == 'J' && name.find_first_not_of("0123456789", 1) > name.size();
  if (!is_numbered) return identifier_name(name);
  return (coordinate.kind == CoordinateKind::angle ? "theta" : "d") + name.substr(1);
}

/// Makes polynomials of the spec's expressions over its parameters.
struct ParameterFactory {
  SpecSymbols& symbols;

  static Polynomial number(const std::string& text) { return {Rational::parse(text)}; }
  Polynomial name(const std::string& name) const { return symbols.parameter(name); }
  static bool is_function(const std::string&) { return true; }
  static Polynomial call(const std::string& function, const Polynomial&) {
    throw FormulaError(function + " is not a polynomial");
  }
  static Polynomial power(const Polynomial& base, int exponent) { return formulas::power(base, exponent); }
  static Polynomial quotient(const Polynomial& a, const Polynomial& b) { return a * formulas::power(b, -1); }
};

namespace {

bool is_equal_to_rounding(double a, double b) { return std::abs(a - b) <= 1e-12 * (std::abs(a) + std::abs(b)); }

}  // namespace

bool find_decimal(double ratio, Rational& decimal) {
  if (!std::isfinite(ratio) || ratio == 0) return false;
  char text[40];
  std::snprintf(text, sizeof text, "%.6g", ratio);
  if (!is_equal_to_rounding(std::strtod(text, nullptr), ratio)) return false;
  decimal = Rational::parse(text);
  return true;
}

SpecSymbols::SpecSymbols(Ring& ring, const ParametricModel& model, const study::SpecNumberTexts& texts,
                         const TreeOptions& options)
    : ring_(&ring),
      model_(&model),
      texts_(&texts),
      is_inlining_(options.expressions == ParameterExpressions::inlined),
      inlined_(options.inlined) {
  for (const study::ParameterText& parameter : texts.parameters) definitions_[parameter.name] = parameter.text;
  for (const study::NamedExpression& parameter : model.parameters())
    symbols_[parameter.name] =
        ring.add_symbol(identifier_name(parameter.name), SymbolKind::dimensionless, parameter.value);
  for (const Symbol& symbol : ring.symbols()) perturbed_values_.push_back(model.perturbed_value(symbol.source));
}

Polynomial SpecSymbols::parameter(const std::string& name) {
  const auto known = symbols_.find(name);
  if (known == symbols_.end()) throw FormulaError(name + " is not a parameter");
  const std::string& text = definitions_[name];
  const bool is_expression =
      text.find_first_of("+*/^") != std::string::npos || !expression::find_expression_names(text).values.empty();
  Polynomial polynomial;
  const bool is_inlined = is_inlining_ || inlined_.contains(name);
  if (is_inlined && is_expression && in_progress_.insert(name).second) {
    const bool is_read =
        read(text, Expression(ring_->symbol(known->second).source), SymbolKind::dimensionless, polynomial);
    in_progress_.erase(name);
    if (is_read) return polynomial;
  }
  return Polynomial::of_symbol(*ring_, known->second);
}

/// Numbers are equal if they agree both with the spec's values and with perturbed ones.
bool SpecSymbols::read(const std::string& text, const Expression& source, SymbolKind kind, Polynomial& polynomial) try {
  ParameterFactory make{*this};
  polynomial = FormulaParser<Polynomial, ParameterFactory>(text, make).read();
  if (polynomial.ring() == nullptr) return false;
  const double perturbed = model_->perturbed_value(source),
               parsed = evaluate_polynomial(polynomial, perturbed_values_, {});
  if (!is_equal_to_rounding(parsed, perturbed)) {
    Rational unit = 1;
    if (!find_decimal(perturbed / parsed, unit)) return false;
    polynomial = polynomial * Polynomial(unit);
  }
  if (!is_equal_to_rounding(evaluate_polynomial(polynomial), source.value()) ||
      !is_equal_to_rounding(evaluate_polynomial(polynomial, perturbed_values_, {}), perturbed))
    return false;
  if (polynomial.size() == 1 && polynomial.terms()[0].monomial.size() == 1) {
    const int symbol = polynomial.terms()[0].monomial.symbol(0);
    if (ring_->symbol(symbol).kind == SymbolKind::dimensionless) ring_->set_kind(symbol, kind);
  }
  return true;
} catch (const FormulaError&) {
  return false;  // no polynomial: the number gets its own symbol
}

Polynomial SpecSymbols::polynomial_at(const std::string& path, const Expression& source, const std::string& name,
                                      SymbolKind kind) {
  if (path.empty()) return find(path, source, name, kind);
  const auto known = numbers_.find(path);
  if (known != numbers_.end()) return known->second.value;
  SpecNumber& number = numbers_[path];
  number = {find(path, source, name, kind), name};
  return number.value;
}

Polynomial SpecSymbols::opposite_polynomial_at(const std::string& path, const Expression& source,
                                               const std::string& name, SymbolKind kind) {
  const auto known = numbers_.find(path);
  if (known != numbers_.end()) return known->second.value;
  SpecNumber& number = numbers_[path];
  number = {-find("", -source, name, kind), name};
  return number.value;
}

Polynomial SpecSymbols::find(const std::string& path, const Expression& source, const std::string& name,
                             SymbolKind kind) {
  if (model_->is_zero(source)) return {};
  const auto text = texts_->numbers.find(path);
  if (text != texts_->numbers.end()) {
    const auto known = symbols_.find(text->second);
    if (kind == SymbolKind::ratio && known != symbols_.end() && !inlined_.contains(text->second) &&
        is_equal_to_rounding(perturbed_values_[static_cast<std::size_t>(known->second)],
                             model_->perturbed_value(source))) {
      ring_->set_kind(known->second, kind);
      return Polynomial::of_symbol(*ring_, known->second);
    }
    Polynomial polynomial;
    if (read(text->second, source, kind, polynomial)) return polynomial;
  }
  const double value = source.value();
  if (kind == SymbolKind::ratio && source.is_constant() && std::abs(value) == 1) return {value < 0 ? -1 : 1};
  return Polynomial::of_symbol(*ring_, ring_->add_symbol(identifier_name(name), kind, source));
}

std::set<std::string> list_dependent_parameters(const study::SpecNumberTexts& texts,
                                                const std::vector<std::string>& names) {
  std::set<std::string> changing(names.begin(), names.end()), dependent;
  for (bool has_grown = true; has_grown;) {
    has_grown = false;
    for (const study::ParameterText& parameter : texts.parameters) {
      if (changing.contains(parameter.name)) continue;
      const auto used = expression::find_expression_names(parameter.text).values;
      if (std::none_of(used.begin(), used.end(), [&](const std::string& name) { return changing.contains(name); }))
        continue;
      changing.insert(parameter.name);
      dependent.insert(parameter.name);
      has_grown = true;
    }
  }
  return dependent;
}

namespace {

/// UTF-8 letters and their names in formulas and programs.
constexpr std::pair<const char*, const char*> greek_letter_names[] = {
    {"α", "alpha"}, {"β", "beta"},  {"γ", "gamma"}, {"δ", "delta"},  {"ε", "epsilon"}, {"ζ", "zeta"},   {"η", "eta"},
    {"θ", "theta"}, {"ι", "iota"},  {"κ", "kappa"}, {"λ", "lambda"}, {"μ", "mu"},      {"µ", "mu"},     {"ν", "nu"},
    {"ξ", "xi"},    {"π", "pi"},    {"ρ", "rho"},   {"σ", "sigma"},  {"τ", "tau"},     {"φ", "phi"},    {"χ", "chi"},
    {"ψ", "psi"},   {"ω", "omega"}, {"Γ", "Gamma"}, {"Δ", "Delta"},  {"Θ", "Theta"},   {"Λ", "Lambda"}, {"Ξ", "Xi"},
    {"Π", "Pi"},    {"Σ", "Sigma"}, {"Φ", "Phi"},   {"Ψ", "Psi"},    {"Ω", "Omega"}};

std::string spell_out_greek(std::string name) {
  for (const auto& [letter, word] : greek_letter_names)
    for (std::size_t position = name.find(letter); position != std::string::npos;
         position = name.find(letter, position))
      name.replace(position, std::string(letter).size(), word);
  return name;
}

}  // namespace

std::string identifier_name(const std::string& name) {
  std::string plain;
  for (const char c : spell_out_greek(name)) {
    const bool is_valid = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    plain += is_valid ? c : '_';
  }
  for (const char* reserved : {"sin", "cos", "sqrt", "pi"})
    if (plain == reserved) plain += '_';
  if (plain.empty() || std::isdigit(static_cast<unsigned char>(plain[0])) != 0) plain.insert(plain.begin(), 'x');
  return plain;
}

}  // namespace balance::formulas
