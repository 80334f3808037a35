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
  RingVector3<R> w, dw, a, force, couple;
};

/// Springs between points pull at the frames. Each is written once: positions in the world from the frames below, forces in their axes.
template <class R, class Maker>
void apply_point_springs(const SymbolicTree& tree, Maker& make, const std::vector<FrameOf<R>>& frames,
                         std::vector<FrameMotion<R>>& motions) {
  const auto parent = [&](int frame) { return tree.frames[static_cast<std::size_t>(frame)].parent; };
  const auto at = [&](int frame) -> const FrameOf<R>& { return frames[static_cast<std::size_t>(frame)]; };
  const auto in_world = [&](const FramePoint& place) {
    RingVector3<R> p = convert_vector<R>(place.at, make);
    for (int frame = place.frame; frame > 0; frame = parent(frame)) p = at(frame).offset + to_parent(at(frame), p);
    return p;
  };
  const auto in_frame = [&](int frame, RingVector3<R> v) {
    std::vector<int> chain;
    for (int k = frame; k > 0; k = parent(k)) chain.push_back(k);
    for (auto k = chain.rbegin(); k != chain.rend(); ++k) v = to_frame(at(*k), v);
    return v;
  };
  const auto transmit = [&](const FramePoint& place, const RingVector3<R>& force) {
    FrameMotion<R>& m = motions[static_cast<std::size_t>(place.frame)];
    m.force = m.force + force;
    m.couple = m.couple + cross(convert_vector<R>(place.at, make), force);
  };
  for (const LinearSpring& spring : tree.springs) {
    const RingVector3<R> d = in_world(spring.b) - in_world(spring.a);
    R tension = make.convert(spring.stiffness);  // per length
    if (spring.length >= 0)
      tension = tension - tension * make.convert(spring.free_length) * make.inverse(make.root(dot(d, d)));
    const RingVector3<R> force = scale_vector(tension, d);
    transmit(spring.b, in_frame(spring.b.frame, force));
    transmit(spring.a, in_frame(spring.a.frame, RingVector3<R>{-force[0], -force[1], -force[2]}));
  }
}

/// Torques of the columns; weight and springs included.
template <class R, class Maker>
std::vector<R> newton_euler_torques(const SymbolicTree& tree, Maker& make, const VariableRates<R>& rates) {
  using Motion = FrameMotion<R>;
  const RingVector3<R> zero{R(0), R(0), R(0)};
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  std::vector<Motion> all(frames.size(), Motion{zero, zero, zero, zero, zero});
  all[0].a = zero - convert_vector<R>(tree.gravity, make);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameOf<R>& at = frames[i];
    const SymbolicFrame& frame = *at.frame;
    const Motion& parent = all[static_cast<std::size_t>(frame.parent)];
    Motion& m = all[i];
    const RingVector3<R> wr = cross(parent.w, at.offset);
    m.w = to_frame(at, parent.w), m.dw = to_frame(at, parent.dw);
    m.a = to_frame(at, parent.a + (cross(parent.dw, at.offset) + cross(parent.w, wr)));
    if (frame.variable >= 0) {
      const R& v = rates.rate[static_cast<std::size_t>(frame.variable)];
      const R& dv = rates.acceleration[static_cast<std::size_t>(frame.variable)];
      const RingVector3<R> ev = unit_vector(frame.axis, frame.sign > 0 ? v : -v);
      const RingVector3<R> edv = unit_vector(frame.axis, frame.sign > 0 ? dv : -dv);
      const RingVector3<R> coriolis = cross(m.w, ev);
      if (frame.angle >= 0) {
        m.dw = m.dw + (coriolis + edv);
        m.w = m.w + ev;
      } else {
        m.a = m.a + (edv + (coriolis + coriolis));
      }
    }
    const auto& [mass, h, I] = at.mass;
    m.force = scale_vector(mass, m.a) + (cross(m.dw, h) + cross(m.w, cross(m.w, h)));
    m.couple = I * m.dw + (cross(m.w, I * m.w) + cross(h, m.a));
  }
  apply_point_springs(tree, make, frames, all);
  std::vector<R> torque(tree.columns.size(), R(0));
  for (const JointSpring& spring : tree.joint_springs) {
    const R force = make.convert(spring.stiffness) * make.symbol(spring.symbol) - make.convert(spring.preload);
    for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(spring.variable)].follows)
      torque[static_cast<std::size_t>(column)] = torque[static_cast<std::size_t>(column)] + make.convert(ratio) * force;
  }
  for (std::size_t i = frames.size(); i-- > 1;) {
    const SymbolicFrame& frame = *frames[i].frame;
    const Motion& m = all[i];
    if (frame.variable >= 0) {
      const R& along = (frame.angle >= 0 ? m.couple : m.force)[static_cast<std::size_t>(frame.axis)];
      for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(frame.variable)].follows) {
        R& sum = torque[static_cast<std::size_t>(column)];
        const R part = make.convert(ratio) * along;
        sum = frame.sign > 0 ? sum + part : sum - part;
      }
    }
    Motion& parent = all[static_cast<std::size_t>(frame.parent)];
    const RingVector3<R> force = to_parent(frames[i], m.force);
    parent.couple = parent.couple + (to_parent(frames[i], m.couple) + cross(frames[i].offset, force));
    parent.force = parent.force + force;
  }
  return torque;
}

}  // namespace balance::formulas
