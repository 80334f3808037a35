#pragma once
/// Inverse dynamics over any ring. Source: R. Featherstone, Rigid Body
/// Dynamics Algorithms, section 5.3. Of the ring's maker it asks for R root(const R&) and R inverse(const R&), too: springs have
/// lengths. Private to formulas.

#include "balance/formulas/frames_over.hpp"

#include <vector>

namespace balance::formulas {

/// Rate and acceleration of every variable over R.
template <class R>
struct VariableRates {
  std::vector<R> rate, acceleration;
};

/// Of one frame, in its axes; what its joint transmits about its origin.
template <class R>
struct FrameMotion {
  Triple<R> w, dw, a, force, couple;
};

/// Springs between points pull at the frames. Each is written once: positions in the world from the frames below, forces in their axes.
template <class R, class Maker>
void pull(const SymbolicTree& tree, Maker& make, const std::vector<FrameOf<R>>& frames,
          std::vector<FrameMotion<R>>& motions) {
  const auto parent = [&](int frame) { return tree.frames[static_cast<std::size_t>(frame)].parent; };
  const auto at = [&](int frame) -> const FrameOf<R>& { return frames[static_cast<std::size_t>(frame)]; };
  const auto in_world = [&](const Place& place) {
    Triple<R> p = made<R>(place.at, make);
    for (int frame = place.frame; frame > 0; frame = parent(frame)) p = at(frame).offset + up(at(frame), p);
    return p;
  };
  const auto in_frame = [&](int frame, Triple<R> v) {
    std::vector<int> chain;
    for (int k = frame; k > 0; k = parent(k)) chain.push_back(k);
    for (auto k = chain.rbegin(); k != chain.rend(); ++k) v = down(at(*k), v);
    return v;
  };
  const auto transmit = [&](const Place& place, const Triple<R>& force) {
    FrameMotion<R>& m = motions[static_cast<std::size_t>(place.frame)];
    m.force = m.force + force;
    m.couple = m.couple + cross(made<R>(place.at, make), force);
  };
  for (const LinearSpring& spring : tree.springs) {
    const Triple<R> d = in_world(spring.b) - in_world(spring.a);
    R tension = make.of(spring.stiffness);  // per length
    if (spring.length >= 0)
      tension = tension - tension * make.of(spring.free_length) * make.inverse(make.root(dot(d, d)));
    const Triple<R> force = scaled(tension, d);
    transmit(spring.b, in_frame(spring.b.frame, force));
    transmit(spring.a, in_frame(spring.a.frame, Triple<R>{-force[0], -force[1], -force[2]}));
  }
}

/// Torques of the columns; weight and springs included.
template <class R, class Maker>
std::vector<R> inverse_dynamics(const SymbolicTree& tree, Maker& make, const VariableRates<R>& rates) {
  using Motion = FrameMotion<R>;
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
  pull(tree, make, frames, all);
  std::vector<R> torque(tree.columns.size(), R(0));
  for (const JointSpring& spring : tree.joint_springs) {
    const R force = make.of(spring.stiffness) * make.symbol(spring.symbol) - make.of(spring.preload);
    for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(spring.variable)].follows)
      torque[static_cast<std::size_t>(column)] = torque[static_cast<std::size_t>(column)] + make.of(ratio) * force;
  }
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
