#include "balance/formulas/frame_builder.hpp"

#include "balance/base/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace balance::formulas {

namespace {

constexpr double tiny = 1e-12;

/// Whole right angles in a turn, or none.
bool quarter_turns(double angle, int& count) {
  const double quarters = angle / (std::numbers::pi / 2);
  count = static_cast<int>(std::lround(quarters)) & 3;
  return std::abs(quarters - std::round(quarters)) < tiny;
}

}  // namespace

namespace {

Alignment align_fixed(const Vector3& u) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(std::abs(u[k]) - 1) < tiny) return {{}, k, u[k] > 0 ? 1 : -1};
  if (std::abs(u.z()) < tiny) return {{{2, elementary::atan2(u.y(), u.x())}}, 0, 1};
  if (std::abs(u.x()) < tiny) return {{{0, elementary::atan2(u.z(), u.y())}}, 1, 1};
  if (std::abs(u.y()) < tiny) return {{{1, -elementary::atan2(u.z(), u.x())}}, 0, 1};
  return {{{2, elementary::atan2(u.y(), u.x())}, {1, -elementary::asin(std::clamp(u.z(), -1.0, 1.0))}}, 0, 1};
}

std::vector<FixedTurn> fixed_turns_of(const Matrix3& R) {
  std::vector<FixedTurn> turns;
  const double pitch = elementary::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const bool locked = std::hypot(R(0, 0), R(1, 0)) < tiny;
  const double yaw = locked ? elementary::atan2(-R(0, 1), R(1, 1)) : elementary::atan2(R(1, 0), R(0, 0));
  const double roll = locked ? 0 : elementary::atan2(R(2, 1), R(2, 2));
  for (const auto& [axis, angle] : {std::pair{2, yaw}, {1, pitch}, {0, roll}})
    if (std::abs(angle) > tiny) turns.push_back({axis, angle});
  return turns;
}

Expression hypotenuse(const Expression& a, const Expression& b) { return sqrt(a * a + b * b); }

/// Turns that are none whatever the numbers are, left out.
std::vector<FixedTurn> without_none(std::vector<FixedTurn> turns) {
  std::erase_if(turns, [](const FixedTurn& turn) { return turn.angle.is_constant() && turn.angle.value() == 0; });
  return turns;
}

}  // namespace

Alignment align(const Vector3E& u) {
  if (is_constant(u)) return align_fixed(values_of(u));
  return {without_none({{2, atan2(u.y(), u.x())}, {1, atan2(u.z(), hypotenuse(u.x(), u.y())), -1}}), 0, 1};
}

std::vector<FixedTurn> turns_of(const Matrix3E& R) {
  if (is_constant(R)) return fixed_turns_of(values_of(R));
  return without_none({{2, atan2(R(1, 0), R(0, 0))},
                       {1, atan2(R(2, 0), hypotenuse(R(0, 0), R(1, 0))), -1},
                       {0, atan2(R(2, 1), R(2, 2))}});
}

std::vector<FixedTurn> reversed(std::vector<FixedTurn> turns) {
  std::reverse(turns.begin(), turns.end());
  for (FixedTurn& turn : turns) turn.sign = -turn.sign;
  return turns;
}

FrameBuilder::FrameBuilder(Ring& ring, SymbolicTree& tree) : ring_(ring), tree_(tree) {
  tree_.frames.assign(1, {});
  runs_.assign(1, {-1, -1, -1});
}

int FrameBuilder::run_of(const Place& from, int axis) {
  int& run = runs_[static_cast<std::size_t>(from.frame)][static_cast<std::size_t>(axis)];
  if (run < 0) run = run_count_++;
  return run;
}

int FrameBuilder::add_frame(Frame frame) {
  tree_.frames.push_back(std::move(frame));
  runs_.push_back({-1, -1, -1});
  return static_cast<int>(tree_.frames.size()) - 1;
}

int FrameBuilder::fixed_angle(int run, const Expression& value) {
  for (const int angle : fixed_) {
    const Angle& known = ring_.angle(angle);
    const bool same = value.is_constant() && known.source.is_constant() ? std::abs(known.value - value.value()) < tiny
                                                                        : known.source.node() == value.node();
    if (known.run == run && same) return angle;
  }
  fixed_.push_back(ring_.add_fixed_angle("alpha" + std::to_string(fixed_.size() + 1), run, value));
  return fixed_.back();
}

Place FrameBuilder::turned(const Place& from, const std::vector<FixedTurn>& turns) {
  Place at = from;
  for (const FixedTurn& turn : turns) at = turned_once(at, turn);
  return at;
}

Place FrameBuilder::turned_once(const Place& from, const FixedTurn& turn) {
  Frame frame;
  frame.parent = from.frame, frame.offset = from.at, frame.axis = turn.axis;
  const auto k = static_cast<std::size_t>(turn.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  int quarters = 0;
  const double value = turn.angle.value();
  if (!turn.angle.is_constant() || !quarter_turns(turn.sign * value, quarters)) {
    const int run = run_of(from, turn.axis);
    const bool negative = turn.angle.is_constant() && value < 0;
    frame.sign = negative ? -turn.sign : turn.sign;
    frame.angle = fixed_angle(run, negative ? Expression(-value) : turn.angle);
    const int turned = add_frame(frame);
    runs_.back()[k] = run;
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
  for (std::size_t a = 0; a < 3; ++a) runs_.back()[a] = run_of(from, axes[a]);
  return {turned, {}};
}

Place FrameBuilder::moved_by(const Place& from, const Vector3E& direction, int variable, int sign) {
  const Alignment along = align(direction);
  return turned(moved_along(from, along, variable, sign), reversed(along.turns));
}

Place FrameBuilder::moved_along(const Place& from, const Alignment& along, int variable, int sign) {
  const Place base = turned(from, along.turns);
  Frame frame;
  frame.parent = base.frame, frame.offset = base.at, frame.variable = variable;
  frame.axis = along.axis, frame.sign = sign * along.sign;
  Variable& moving = tree_.variables[static_cast<std::size_t>(variable)];
  if (moving.is_angle) {
    const int run = run_of(base, along.axis);
    if (moving.index < 0) moving.index = ring_.add_angle(names_[static_cast<std::size_t>(variable)], run);
    frame.angle = moving.index;
    const int turned_to = add_frame(frame);
    runs_.back()[static_cast<std::size_t>(along.axis)] = run;
    return {turned_to, {}};
  }
  frame.slide = moving.index;
  const int slid = add_frame(frame);
  for (int axis = 0; axis < 3; ++axis) runs_.back()[static_cast<std::size_t>(axis)] = run_of(base, axis);
  return {slid, {}};
}

int FrameBuilder::add_variable(const std::string& name, bool is_angle) {
  Variable variable;
  variable.is_angle = is_angle;
  variable.index = is_angle ? -1 : ring_.add_symbol(name, SymbolKind::slide, 0);
  tree_.variables.push_back(variable);
  names_.push_back(name);
  return static_cast<int>(tree_.variables.size()) - 1;
}

}  // namespace balance::formulas
