#pragma once
/// The numbers of a mechanism's parts as polynomials, under the names that the field gives them.

#include "balance/synthesis/formulas/symbolic_polynomial.hpp"
#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace balance::formulas {

/// The numbers of a mechanism as polynomials of symbols.
class SpecSymbols {
 public:
  /// @param texts what the spec says where; parameters become symbols under their names
  /// @param put_in parameters that are expressions become what these say; but for ratios
  SpecSymbols(Ring& ring, const ParametricModel& model, const SpecNumberTexts& texts, bool put_in);

  /// A number of the mechanism. What is zero whatever the parameters are is zero; what the spec makes of parameters is that; else it
  /// gets a symbol of its own.
  /// @param path in the spec: "bodies.link1.com[0]"; empty: none
  /// @param source SI
  /// @param name of the symbol if it needs one, as the field calls it: "lg1"
  Polynomial polynomial_at(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  Ring& ring() { return *ring_; }

 private:
  Polynomial find(const std::string& path, const Expression& source, const std::string& name, SymbolKind kind);
  Polynomial parameter(const std::string& name);
  bool read(const std::string& text, const Expression& source, SymbolKind kind, Polynomial& found);

  Ring* ring_;
  const ParametricModel* model_;
  const SpecNumberTexts* texts_;
  bool is_inlining_;
  std::map<std::string, int> symbols_;              ///< of parameters
  std::map<std::string, std::string> definitions_;  ///< of parameters that are put in: their expressions
  std::vector<double> perturbed_values_;     ///< values of parameters, by symbol, where all inputs are other numbers
  std::set<std::string> in_progress_;        ///< being read
  std::map<std::string, Polynomial> known_;  ///< by path
  friend struct ParameterFactory;
};

/// A name that formulas, C and Python can have: letters, digits and `_`; Greek letters are written out.
std::string identifier_name(const std::string& name);

class MechanismSymbols {
 public:
  MechanismSymbols(Ring& ring, const ParametricModel& model, const SpecNumberTexts& texts, const TreeOptions& options);

  /// Where a joint holds one of its bodies, from that body's origin: the point that it names, or its own numbers.
  Vector joint_point(int joint, bool first);
  Vector spring_point(std::size_t spring, bool first);
  Mass body(int index);
  Mass attachment(int index);
  Mass disc(int index);
  /// Whether a disc's inertia is stated as an axial and a transverse moment.
  bool is_rotor(int disc) const;
  /// Of a rotor, in axes of which one is the disc's.
  Mass rotor(int disc, int axis);
  /// Of its centre, on its carrier.
  Vector disc_position(int index);
  Vector gravity();
  Polynomial ratio(int disc);
  Polynomial coupling_ratio(std::size_t coupling);
  Polynomial coupling_offset(std::size_t coupling);
  /// Of one coordinate in what a disc or a coupling follows.
  Polynomial disc_term(int disc, std::size_t term);
  Polynomial coupling_term(std::size_t coupling, std::size_t term);
  Polynomial stiffness(std::size_t spring);
  Polynomial free_length(std::size_t spring);
  Polynomial preload(std::size_t spring);
  /// From where something rolls on a plane to its centre, while it stands upright. @throws FormulaError for a plane across no axis
  Vector wheel_centre_offset(int joint);
  /// theta1 of the angle J1, d3 of the slide J3, else the coordinate's own name.
  std::string coordinate_name(int coordinate) const;
  /// Symbols of first moments, masses, inertias, in the order of list_parameters.
  const std::vector<int>& inertial() const { return inertial_; }

 private:
  struct MassText {
    std::string path, name;  ///< "discs.d4", "d4" behind letters
    Matrix3E inertia;
  };
  using NamedPointE = NamedPointOf<Expression>;
  Vector position(const std::string& path, const Vector3E& position, const std::string& along,
                  const std::string& behind, SymbolKind kind);
  /// @param path of what refers to the place: `joints.J1.connects[0]`
  Vector referenced_point(const std::string& path, int body, const Vector3E& position);
  Vector unnamed_point(const std::string& path, int body, const Vector3E& position, const std::string& name);
  Vector attachment_position(const std::string& path, int body, const Vector3E& position, const std::string& name);
  Mass about_com(const Polynomial& mass, const Vector& com, const MassText& text);
  Mass about_origin(const std::string& name, const Expression& mass, const Vector3E& com, const Matrix3E& inertia);
  RingSymmetric3<Polynomial> inertia(const MassText& text);
  const NamedPointE* named_point(const std::string& path, int body, const Vector3E& position) const;
  bool planar() const { return mechanism_.space == SpaceKind::planar; }
  int count_nonzero(const Vector3E& v) const;

  SpecSymbols numbers_;
  const MechanismOf<Expression>& mechanism_;
  const ParametricModel& model_;
  const SpecNumberTexts& texts_;
  Ring& ring_;
  bool origin_;
  std::set<int> has_length_;  ///< bodies whose first length has its name
  std::vector<int> inertial_;
  std::map<std::string, Vector> points_;  ///< by the path that states them
};

}  // namespace balance::formulas
