#pragma once
/// The numbers of a mechanism's parts as polynomials, under the names that the field gives them. Private to formulas.

#include "balance/formulas/numbers.hpp"
#include "balance/formulas/symbolic_tree.hpp"

#include <map>
#include <set>
#include <string>
#include <vector>

namespace balance::formulas {

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
