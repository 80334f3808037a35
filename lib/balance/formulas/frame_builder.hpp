#pragma once
/// Puts frames behind each other. Private to formulas.

#include "balance/formulas/number_model.hpp"
#include "balance/formulas/symbolic_tree.hpp"

#include <vector>

namespace balance::formulas {

/// A turn about a coordinate axis that does not depend on the pose [rad].
struct FixedRotation {
  int axis = 0;
  Expression angle;
  int sign = 1;  ///< −1: backwards
};

/// A coordinate axis k of a frame that the turns lead to, so that it points along a unit vector.
struct Alignment {
  std::vector<FixedRotation> turns;
  int axis = 0;
  int sign = 1;
};
/// Where the spec lets the direction change, the turns are those of any direction.
Alignment find_alignment(const Vector3E& direction);
/// Turns one after another that make a rotation.
std::vector<FixedRotation> decompose_rotation(const Matrix3E& rotation);
std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> turns);

class FrameBuilder {
 public:
  FrameBuilder(Ring& ring, SymbolicTree& tree);

  /// The run of an angle that turns about an axis there: new, or that of the last joint with a parallel axis.
  int group_of(const FramePoint& from, int axis);
  FramePoint rotate(const FramePoint& from, const std::vector<FixedRotation>& turns);
  /// @param sign −1: backwards
  FramePoint apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign);
  /// The same, left in axes of which `along` has one.
  FramePoint apply_aligned_joint(const FramePoint& from, const Alignment& along, int variable, int sign);
  /// The number of a new variable; its angle gets its run when it is first turned by.
  int add_variable(const std::string& name, bool is_angle);

 private:
  FramePoint rotate_once(const FramePoint& from, const FixedRotation& turn);
  int fixed_angle(int run, const Expression& value);
  int add_frame(SymbolicFrame frame);

  Ring& ring_;
  SymbolicTree& tree_;
  std::vector<std::string> names_;          ///< of variables
  std::vector<std::array<int, 3>> groups_;  ///< per frame and axis; −1: none yet
  std::vector<int> fixed_;                  ///< angles of the ring that do not change
  int run_count_ = 0;
};

}  // namespace balance::formulas
