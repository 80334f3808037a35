#pragma once
/// Inverse dynamics over any ring. Source: R. Featherstone, Rigid Body
/// Dynamics Algorithms, section 5.3. Private to formulas.

#include "balance/formulas/frames_over.hpp"

#include <vector>

namespace balance::formulas {

/// Rate and acceleration of every variable over R.
template <class R>
struct VariableRates {
  std::vector<R> rate, acceleration;
};

/// Torques of the columns; weight included, springs not.
template <class R, class Maker>
std::vector<R> inverse_dynamics(const SymbolicTree& tree, Maker& make, const VariableRates<R>& rates) {
  struct Motion {
    Triple<R> w, dw, a, force, couple;
  };
  const Triple<R> zero{R(0), R(0), R(0)};
  const std::vector<FrameOf<R>> frames = frames_over<R>(tree, make);
  std::vector<Motion> all(frames.size(), Motion{zero, zero, zero, zero, zero});
  all[0].a = zero - made<R>(tree.gravity, make);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameOf<R>& at = frames[i];
    const Frame& frame = *at.frame;
    const Motion& parent = all[static_cast<std::size_t>(frame.parent)];
    Motion& m = all[i];
    const Triple<R> wr = cross(parent.w, at.offset);
    m.w = down(at, parent.w), m.dw = down(at, parent.dw);
    m.a = down(at, parent.a + (cross(parent.dw, at.offset) + cross(parent.w, wr)));
    if (frame.variable >= 0) {
      const R& v = rates.rate[static_cast<std::size_t>(frame.variable)];
      const R& dv = rates.acceleration[static_cast<std::size_t>(frame.variable)];
      const Triple<R> ev = unit_vector(frame.axis, frame.sign > 0 ? v : -v);
      const Triple<R> edv = unit_vector(frame.axis, frame.sign > 0 ? dv : -dv);
      const Triple<R> coriolis = cross(m.w, ev);
      if (frame.angle >= 0) {
        m.dw = m.dw + (coriolis + edv);
        m.w = m.w + ev;
      } else {
        m.a = m.a + (edv + (coriolis + coriolis));
      }
    }
    const auto& [mass, h, I] = at.mass;
    m.force = scaled(mass, m.a) + (cross(m.dw, h) + cross(m.w, cross(m.w, h)));
    m.couple = I * m.dw + (cross(m.w, I * m.w) + cross(h, m.a));
  }
  std::vector<R> torque(tree.columns.size(), R(0));
  for (std::size_t i = frames.size(); i-- > 1;) {
    const Frame& frame = *frames[i].frame;
    const Motion& m = all[i];
    if (frame.variable >= 0) {
      const R& along = (frame.angle >= 0 ? m.couple : m.force)[static_cast<std::size_t>(frame.axis)];
      for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(frame.variable)].follows) {
        R& sum = torque[static_cast<std::size_t>(column)];
        const R part = make.of(ratio) * along;
        sum = frame.sign > 0 ? sum + part : sum - part;
      }
    }
    Motion& parent = all[static_cast<std::size_t>(frame.parent)];
    const Triple<R> force = up(frames[i], m.force);
    parent.couple = parent.couple + (up(frames[i], m.couple) + cross(frames[i].offset, force));
    parent.force = parent.force + force;
  }
  return torque;
}

}  // namespace balance::formulas
