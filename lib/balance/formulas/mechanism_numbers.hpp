#pragma once
/// The numbers of a mechanism's parts as polynomials, under the names that the field gives them. Private to formulas.

#include "balance/formulas/numbers.hpp"
#include "balance/formulas/symbolic_tree.hpp"

#include <array>
#include <map>
#include <set>
#include <utility>

namespace balance::formulas {

class MechanismNumbers {
 public:
  MechanismNumbers(Ring& ring, const Mechanism& mechanism, const SpecTexts& texts, const TreeOptions& options);

  /// A place on a body from its origin: one of its named points, or its own numbers.
  Vector point(int body, const Vector3& position);
  Mass body(int index);
  Mass attachment(int index);
  Mass disc(int index);
  /// Of its centre, on its carrier.
  Vector disc_place(int index);
  Vector gravity();
  Polynomial ratio(int disc);
  Polynomial coupling_ratio(std::size_t coupling);
  /// Of one coordinate in what a disc or a coupling follows.
  Polynomial disc_term(int disc, const CoordinateTerm& term);
  Polynomial coupling_term(std::size_t coupling, const CoordinateTerm& term);
  Polynomial stiffness(std::size_t spring);
  Polynomial free_length(std::size_t spring);
  Polynomial preload(std::size_t spring);
  /// From where something rolls on a plane to its centre, while it stands upright. @throws FormulaError for a plane across no axis
  Vector rise(int joint);
  /// theta1 of the angle J1, d3 of the slide J3, else the coordinate's own name.
  std::string coordinate_name(int coordinate) const;
  /// Symbols of first moments, masses, inertias, in the order of list_parameters.
  const std::vector<int>& inertial() const { return inertial_; }

 private:
  struct MassText {
    std::string path, name;  ///< "discs.d4", "d4" behind letters
    Matrix3 inertia;
  };
  Vector place(const std::string& path, const Vector3& position, const std::string& along, const std::string& behind,
               SymbolKind kind);
  Vector carried_at(const std::string& path, int body, const Vector3& position, const std::string& name);
  Mass about_com(const Polynomial& mass, const Vector& com, const MassText& text);
  Mass about_origin(const std::string& name, double mass, const Vector3& com, const Matrix3& inertia);
  Symmetric<Polynomial> inertia(const MassText& text);
  const NamedPoint* named_point(int body, const Vector3& position) const;
  bool planar() const { return mechanism_.space == SpaceKind::planar; }

  Numbers numbers_;
  const Mechanism& mechanism_;
  const SpecTexts& texts_;
  bool origin_;
  std::set<int> has_length_;  ///< bodies whose first length has its name
  std::vector<int> inertial_;
  std::map<std::pair<int, std::array<double, 3>>, Vector> points_;  ///< by body and position
};

}  // namespace balance::formulas
