#pragma once
/// A design that minimises figures of forces along a motion, as a problem over a box of lengths: which free numbers are
/// lengths, which are masses and places, and what the figures are.

#include "balance/mechanics/results/result.hpp"
#include "balance/synthesis/certificate/motion_enclosure.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace balance::certificate {

/// A force whose figure is minimised, or that a goal makes vanish.
struct MotionForce {
  enum class Kind { shaking_force, shaking_moment, torque };
  Kind kind = Kind::shaking_force;
  std::optional<int> component = {};  ///< of the shaking force
  Vector2 about = Vector2::Zero();    ///< world point of the shaking moment [m]
  bool has_named_point = false;       ///< it is a point of the ground in the spec
  std::optional<int> actuator = {};   ///< of the torque; none: all
  bool is_combined = false;           ///< the norm of all torques; else the worst one

  /// Numbers per moment in each series, and number of series.
  int components(std::size_t actuators) const;
  int series(std::size_t actuators) const;
};

/// weight · rms or peak of a force.
struct ForceFigure {
  double weight = 1;  ///< positive
  bool is_peak = false;
  MotionForce force;
};

/// A counterweight, payload or disc with free mass, place or moment of inertia.
struct FreeElement {
  int attachment = -1, disc = -1;            ///< into the mechanism; one of them
  int mass_number = -1;                      ///< free number that is its mass; −1: the mass is fixed
  std::array<int, 2> place_numbers{-1, -1};  ///< free numbers that are its coordinates on the body; −1: fixed
  int inertia_number = -1;                   ///< free number that is its moment of inertia about its centre of mass
  bool is_added = false;                     ///< counts as added mass
};

struct FigureProblem {
  std::string reason;        ///< why there is none: completes "no certificate because …"
  std::vector<int> lengths;  ///< free numbers that are neither masses nor places, and whose bounds differ
  VectorX lower, upper;      ///< of all free numbers
  std::vector<FreeElement> elements;
  int trajectory = 0;  ///< along which the figures are taken
  PlanarDrive drive;
  std::vector<ForceFigure> figures;
  std::vector<MotionForce> vanishing;  ///< what the goals make zero along the motion
  std::vector<std::string> ignored;    ///< goals and limits that the bound does without
  std::optional<double> max_added_mass;
};

/// What the design asks for, in terms of forces.
struct FigureRequest {
  std::vector<ForceFigure> figures;
  int trajectory = 0;
  bool keeps_assembly_mode = true;  ///< designs must be in the mode of the start values
};

FigureProblem read_figure_problem(const DesignSpace& space, const FigureRequest& request);

}  // namespace balance::certificate
