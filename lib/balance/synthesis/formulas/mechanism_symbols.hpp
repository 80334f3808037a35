#pragma once
/// The numbers of a mechanism as polynomials, under the names that are usual in the field.

#include "balance/synthesis/formulas/symbolic_polynomial.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace balance::formulas {

/// A number of the mechanism as the formulas have it.
struct SpecNumber {
  Polynomial value;
  std::string name;  ///< of the symbol that it would get
};

/// The numbers of a mechanism as polynomials of symbols.
class SpecSymbols {
 public:
  /// @param texts of the spec's numbers; parameters become symbols under their names
  /// @param options which parameters are replaced by their expressions
  SpecSymbols(Ring& ring, const ParametricModel& model, const study::SpecNumberTexts& texts,
              const TreeOptions& options);

  /// A number of the mechanism. It is zero if it is zero for all parameters. If the spec defines it by parameters, it
  /// is that expression; otherwise it gets its own symbol.
  /// @param path in the spec: "bodies.link1.com[0]"; empty: none
  /// @param source SI
  /// @param name of the symbol if it needs one, as usual in the field: "lg1"
  Polynomial polynomial_at(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  /// The same for a number that the spec states with the opposite sign, as gravity, whose symbol is positive.
  Polynomial opposite_polynomial_at(const std::string& path, const Expression& source, const std::string& name,
                                    SymbolKind kind);
  /// A parameter: its symbol, or its expression where it is inlined.
  /// @throws FormulaError for a name that is no parameter
  Polynomial parameter(const std::string& name);
  Ring& ring() { return *ring_; }
  /// The numbers so far, by path.
  const std::map<std::string, SpecNumber>& numbers() const { return numbers_; }

 private:
  Polynomial find(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  bool read(const std::string& text, const Expression& source, SymbolKind kind, Polynomial& polynomial);

  Ring* ring_;
  const ParametricModel* model_;
  const study::SpecNumberTexts* texts_;
  bool is_inlining_;
  std::set<std::string> inlined_;
  std::map<std::string, int> symbols_;              ///< of parameters
  std::map<std::string, std::string> definitions_;  ///< of inlined parameters: their expressions
  std::vector<double> perturbed_values_;            ///< values of parameters, by symbol, with all inputs perturbed
  std::set<std::string> in_progress_;               ///< parameters being read
  std::map<std::string, SpecNumber> numbers_;       ///< by path
};

/// The parameters whose expressions contain one of these, and those whose expressions contain such a parameter.
std::set<std::string> list_dependent_parameters(const study::SpecNumberTexts& texts,
                                                const std::vector<std::string>& names);

/// The decimal fraction that a ratio of units is, if it is a short one.
bool find_decimal(double ratio, Rational& decimal);

/// A valid name in formulas, C and Python: letters, digits and `_`; Greek letters are spelled out.
std::string identifier_name(const std::string& name);

class MechanismSymbols {
 public:
  MechanismSymbols(Ring& ring, const ParametricModel& model, const study::SpecNumberTexts& texts,
                   const TreeOptions& options);

  /// Position of a joint on one of its bodies, from that body's origin: a named point, or the joint's own numbers.
  Vector joint_point(int joint, bool first);
  Vector spring_point(std::size_t spring, bool first);
  /// Position of the tool on its body.
  Vector tool_point();
  /// Position of a named point on its body.
  Vector body_point(int body, const std::string& name);
  Mass body(int index);
  Mass attachment(int index);
  Mass disc(int index);
  /// Whether a disc's inertia is stated as an axial and a transverse moment.
  bool is_rotor(int disc) const;
  /// The inertia of a rotor, in axes one of which is the disc's.
  Mass rotor(int disc, int axis);
  /// Position of a disc's centre on its carrier.
  Vector disc_position(int index);
  Vector gravity();
  Polynomial ratio(int disc);
  Polynomial coupling_ratio(std::size_t coupling);
  Polynomial coupling_offset(std::size_t coupling);
  /// Ratio of one coordinate that a disc or a coupling follows.
  Polynomial disc_term(int disc, std::size_t term);
  /// Radius of a body that rolls.
  Polynomial joint_radius(int joint);
  /// A parameter of the spec, or its expression where it is inlined.
  Polynomial parameter(const std::string& name) { return spec_symbols_.parameter(name); }
  Polynomial coupling_term(std::size_t coupling, std::size_t term);
  Polynomial stiffness(std::size_t spring);
  Polynomial free_length(std::size_t spring);
  Polynomial preload(std::size_t spring);
  /// From the point where a body rolls on a plane to its centre, in the upright pose.
  /// @throws FormulaError for a plane that is not normal to an axis
  Vector wheel_centre_offset(int joint);
  /// theta1 for the angle J1, d3 for the slide J3, otherwise the coordinate's own name.
  std::string coordinate_name(int coordinate) const;
  /// Symbols of first moments, masses and inertias, in the order of list_parameters.
  const std::vector<int>& inertial() const { return inertial_; }
  /// The numbers that the formulas use, by path.
  const std::map<std::string, SpecNumber>& numbers() const { return spec_symbols_.numbers(); }

 private:
  struct MassText {
    std::string path, name;  ///< "discs.d4"; "d4", the suffix of symbols
    Matrix3E inertia;
  };
  using NamedPointE = model::NamedPointOf<Expression>;
  Vector position(const std::string& path, const Vector3E& position, const std::string& single_name,
                  const std::string& suffix, SymbolKind kind);
  /// @param path of the reference to the point: `joints.J1.connects[0]`
  Vector referenced_point(const std::string& path, int body, const Vector3E& position);
  Vector unnamed_point(const std::string& path, int body, const Vector3E& position, const std::string& name);
  Vector attachment_position(const std::string& path, int body, const Vector3E& position, const std::string& name);
  Mass about_com(const Polynomial& mass, const Vector& com, const MassText& text);
  Mass about_origin(const std::string& name, const Expression& mass, const Vector3E& com, const Matrix3E& inertia);
  RingSymmetric3<Polynomial> inertia(const MassText& text);
  const NamedPointE* named_point(const std::string& path, int body, const Vector3E& position) const;
  bool planar() const { return mechanism_.space == SpaceKind::planar; }
  int count_nonzero(const Vector3E& v) const;
  bool is_plain_number(const Expression& x) const;
  const model::JointOf<Expression>* wheel_of(std::size_t coupling) const;

  SpecSymbols spec_symbols_;
  const MechanismOf<Expression>& mechanism_;
  const ParametricModel& model_;
  const study::SpecNumberTexts& texts_;
  Ring& ring_;
  bool is_about_origin_;
  std::set<int> bodies_with_length_;  ///< bodies whose first length already has its name
  std::vector<int> inertial_;
  std::map<std::string, Vector> points_;  ///< by the path that defines them
};

}  // namespace balance::formulas
