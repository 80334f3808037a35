#include "balance/formulas/frame_builder.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::formulas {

namespace {

constexpr double rotation_epsilon = 1e-12;

/// Whole right angles in a turn, or none.
bool has_quarter_turns(double angle, int& count) {
  const double quarters = angle / (std::numbers::pi / 2);
  count = static_cast<int>(std::lround(quarters)) & 3;
  return std::abs(quarters - std::round(quarters)) < rotation_epsilon;
}

}  // namespace

namespace {

Alignment find_fixed_alignment(const Vector3& u) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(std::abs(u[k]) - 1) < rotation_epsilon) return {{}, k, u[k] > 0 ? 1 : -1};
  if (std::abs(u.z()) < rotation_epsilon) return {{{2, elementary::atan2(u.y(), u.x())}}, 0, 1};
  if (std::abs(u.x()) < rotation_epsilon) return {{{0, elementary::atan2(u.z(), u.y())}}, 1, 1};
  if (std::abs(u.y()) < rotation_epsilon) return {{{1, -elementary::atan2(u.z(), u.x())}}, 0, 1};
  return {{{2, elementary::atan2(u.y(), u.x())}, {1, -elementary::asin(std::clamp(u.z(), -1.0, 1.0))}}, 0, 1};
}

std::vector<FixedRotation> decompose_fixed_rotation(const Matrix3& R) {
  std::vector<FixedRotation> turns;
  const double pitch = elementary::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool locked = std::hypot(R(0, 0), R(1, 0)) < rotation_epsilon;
  const double yaw = locked ? elementary::atan2(-R(0, 1), R(1, 1)) : elementary::atan2(R(1, 0), R(0, 0));
  const double roll = locked ? 0 : elementary::atan2(R(2, 1), R(2, 2));
  for (const auto& [axis, angle] : {std::pair{2, yaw}, {1, pitch}, {0, roll}})
    if (std::abs(angle) > rotation_epsilon) turns.push_back({axis, angle});
  return turns;
}

Expression hypotenuse(const Expression& a, const Expression& b) { return sqrt(a * a + b * b); }

/// Turns that are none whatever the numbers are, left out.
std::vector<FixedRotation> remove_identity_rotations(std::vector<FixedRotation> turns) {
  std::erase_if(turns, [](const FixedRotation& turn) { return turn.angle.is_constant() && turn.angle.value() == 0; });
  return turns;
}

}  // namespace

Alignment find_alignment(const Vector3E& u) {
  if (is_constant(u)) return find_fixed_alignment(to_values(u));
  return {remove_identity_rotations({{2, atan2(u.y(), u.x())}, {1, atan2(u.z(), hypotenuse(u.x(), u.y())), -1}}), 0, 1};
}

std::vector<FixedRotation> decompose_rotation(const Matrix3E& R) {
  if (is_constant(R)) return decompose_fixed_rotation(to_values(R));
  return remove_identity_rotations({{2, atan2(R(1, 0), R(0, 0))},
                                    {1, atan2(R(2, 0), hypotenuse(R(0, 0), R(1, 0))), -1},
                                    {0, atan2(R(2, 1), R(2, 2))}});
}

std::vector<FixedRotation> reverse_rotations(std::vector<FixedRotation> turns) {
  std::reverse(turns.begin(), turns.end());
  for (FixedRotation& turn : turns) turn.sign = -turn.sign;
  return turns;
}

FrameBuilder::FrameBuilder(Ring& ring, SymbolicTree& tree) : ring_(ring), tree_(tree) {
  tree_.frames.assign(1, {});
  groups_.assign(1, {-1, -1, -1});
}

int FrameBuilder::group_of(const FramePoint& from, int axis) {
  int& run = groups_[static_cast<std::size_t>(from.frame)][static_cast<std::size_t>(axis)];
  if (run < 0) run = run_count_++;
  return run;
}

int FrameBuilder::add_frame(SymbolicFrame frame) {
  tree_.frames.push_back(std::move(frame));
  groups_.push_back({-1, -1, -1});
  return static_cast<int>(tree_.frames.size()) - 1;
}

int FrameBuilder::fixed_angle(int run, const Expression& value) {
  for (const int angle : fixed_) {
    const Angle& known = ring_.angle(angle);
    const bool same = value.is_constant() && known.source.is_constant()
                          ? std::abs(known.value - value.value()) < rotation_epsilon
                          : known.source.node() == value.node();
    if (known.group == run && same) return angle;
  }
  fixed_.push_back(ring_.add_fixed_angle("alpha" + std::to_string(fixed_.size() + 1), run, value));
  return fixed_.back();
}

FramePoint FrameBuilder::rotate(const FramePoint& from, const std::vector<FixedRotation>& turns) {
  FramePoint at = from;
  for (const FixedRotation& turn : turns) at = rotate_once(at, turn);
  return at;
}

FramePoint FrameBuilder::rotate_once(const FramePoint& from, const FixedRotation& turn) {
  SymbolicFrame frame;
  frame.parent = from.frame, frame.offset = from.at, frame.axis = turn.axis;
  const auto k = static_cast<std::size_t>(turn.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  int quarters = 0;
  const double value = turn.angle.value();
  if (!turn.angle.is_constant() || !has_quarter_turns(turn.sign * value, quarters)) {
    const int run = group_of(from, turn.axis);
    const bool negative = turn.angle.is_constant() && value < 0;
    frame.sign = negative ? -turn.sign : turn.sign;
    frame.angle = fixed_angle(run, negative ? Expression(-value) : turn.angle);
    const int turned = add_frame(frame);
    groups_.back()[k] = run;
    return {turned, {}};
  }
  // axis i comes to lie along j after one quarter
  for (int q = 0; q < quarters; ++q) {
    const int axis = frame.axes[i], sign = frame.signs[i];
    frame.axes[i] = frame.axes[j], frame.signs[i] = frame.signs[j];
    frame.axes[j] = axis, frame.signs[j] = -sign;
  }
  const int turned = add_frame(frame);
  const auto& axes = tree_.frames.back().axes;
  for (std::size_t a = 0; a < 3; ++a) groups_.back()[a] = group_of(from, axes[a]);
  return {turned, {}};
}

FramePoint FrameBuilder::apply_joint(const FramePoint& from, const Vector3E& direction, int variable, int sign) {
  const Alignment along = find_alignment(direction);
  return rotate(apply_aligned_joint(from, along, variable, sign), reverse_rotations(along.turns));
}

FramePoint FrameBuilder::apply_aligned_joint(const FramePoint& from, const Alignment& along, int variable, int sign) {
  const FramePoint base = rotate(from, along.turns);
  SymbolicFrame frame;
  frame.parent = base.frame, frame.offset = base.at, frame.variable = variable;
  frame.axis = along.axis, frame.sign = sign * along.sign;
  JointVariable& moving = tree_.variables[static_cast<std::size_t>(variable)];
  if (moving.is_angle) {
    const int run = group_of(base, along.axis);
    if (moving.index < 0) moving.index = ring_.add_angle(names_[static_cast<std::size_t>(variable)], run);
    frame.angle = moving.index;
    const int turned_to = add_frame(frame);
    groups_.back()[static_cast<std::size_t>(along.axis)] = run;
    return {turned_to, {}};
  }
  frame.slide = moving.index;
  const int slid = add_frame(frame);
  for (int axis = 0; axis < 3; ++axis) groups_.back()[static_cast<std::size_t>(axis)] = group_of(base, axis);
  return {slid, {}};
}

int FrameBuilder::add_variable(const std::string& name, bool is_angle) {
  JointVariable variable;
  variable.is_angle = is_angle;
  variable.index = is_angle ? -1 : ring_.add_symbol(name, SymbolKind::slide, 0);
  tree_.variables.push_back(variable);
  names_.push_back(name);
  return static_cast<int>(tree_.variables.size()) - 1;
}

}  // namespace balance::formulas
