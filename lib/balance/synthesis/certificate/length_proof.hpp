#pragma once
/// The boxes of a branch and bound as a proof of its bound, which can be checked without it.

#include "balance/synthesis/certificate/box_program.hpp"
#include "balance/synthesis/certificate/length_geometry.hpp"

#include <limits>
#include <vector>

namespace balance::certificate {

/// What is shown of a box.
struct ProofStep {
  enum class Kind {
    split,     ///< into the two parts on both sides of a value of a length, which follow: the lower one first
    excluded,  ///< its lengths do not meet a condition
    bounded,   ///< by multipliers
  };
  Kind kind = Kind::split;
  LengthBox box;
  int length = -1;  ///< of a split
  double at = 0;
  int condition = -1;               ///< that excludes the box
  double bound = 0;                 ///< no design with lengths in the box is lighter [kg]
  BoxCertificate multipliers = {};  ///< of the bound
};

/// The proof for one geometry: its box, divided depth first.
struct GeometryProof {
  LengthGeometry geometry;
  std::vector<ProofStep> steps;
};

/// Keeps what a branch and bound did with its boxes.
class ProofRecorder {
 public:
  /// @param parent −1: the whole box of a geometry
  /// @param cuts of the contraction that follows
  /// @return index of the part
  int add(int parent, const LengthBox& box, std::vector<BoxCut> cuts);
  void prove(int part, double bound, const BoxCertificate& multipliers);
  /// As few steps as prove a bound: parts of boxes that have it anyway are left out.
  /// @param root part that is the geometry's whole box
  /// @param bound that the recorded search has shown
  GeometryProof list_steps(int root, const LengthGeometry& geometry, double bound) const;

 private:
  class Lister;
  struct Part {
    LengthBox box;
    std::vector<BoxCut> cuts;
    std::vector<int> parts;
    double bound = -std::numeric_limits<double>::infinity();
    BoxCertificate multipliers;
  };
  std::vector<Part> parts_;
};

}  // namespace balance::certificate
