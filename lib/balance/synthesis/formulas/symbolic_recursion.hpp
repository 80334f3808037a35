#pragma once
/// Inverse dynamics over any ring. Source: R. Featherstone, Rigid Body Dynamics Algorithms, section 5.3. The ring's
/// maker must also provide R root(const R&) and R inverse(const R&), for the lengths of springs.

#include "balance/synthesis/formulas/symbolic_tree.hpp"

#include <vector>

namespace balance::formulas {

// The frames of a tree over any ring R of scalars. A ring's maker provides its numbers:
//     R convert(const Polynomial&)     a polynomial in symbols alone
//     R circular(int angle, bool sine) cos or sin of an angle
//     R symbol(int index)

/// One frame over R, as the recursions use it.
template <class R>
struct FrameOf {
  const SymbolicFrame* frame = nullptr;
  RingVector3<R> offset;  ///< in the parent's axes, including the slide
  R cosine = R(1), sine = R(0);
  RigidBodyInertia<R> mass;
};

template <class R, class Maker>
RingVector3<R> convert_vector(const Vector& v, Maker& make) {
  return {make.convert(v[0]), make.convert(v[1]), make.convert(v[2])};
}

template <class R, class Maker>
std::vector<FrameOf<R>> make_frames(const SymbolicTree& tree, Maker& make) {
  std::vector<FrameOf<R>> frames;
  for (const SymbolicFrame& frame : tree.frames) {
    FrameOf<R> converted;
    converted.frame = &frame;
    converted.offset = convert_vector<R>(frame.offset, make);
    if (frame.slide >= 0) {
      R& axial_offset = converted.offset[static_cast<std::size_t>(frame.axis)];
      axial_offset = frame.sign > 0 ? axial_offset + make.symbol(frame.slide) : axial_offset - make.symbol(frame.slide);
    }
    if (frame.angle >= 0) {
      converted.cosine = make.circular(frame.angle, false);
      converted.sine = make.circular(frame.angle, true);
      if (frame.sign < 0) converted.sine = -converted.sine;
    }
    converted.mass.mass = make.convert(frame.mass.mass);
    converted.mass.moment = convert_vector<R>(frame.mass.moment, make);
    for (std::size_t k = 0; k < 6; ++k) converted.mass.inertia[k] = make.convert(frame.mass.inertia[k]);
    frames.push_back(std::move(converted));
  }
  return frames;
}

/// From a frame's axes to its parent's.
template <class R>
RingVector3<R> to_parent(const FrameOf<R>& at, const RingVector3<R>& v) {
  const SymbolicFrame& frame = *at.frame;
  RingVector3<R> rotated;
  for (std::size_t k = 0; k < 3; ++k)
    rotated[static_cast<std::size_t>(frame.axes[k])] = frame.signs[k] > 0 ? v[k] : -v[k];
  if (frame.angle < 0) return rotated;
  const auto i = static_cast<std::size_t>((frame.axis + 1) % 3), j = static_cast<std::size_t>((frame.axis + 2) % 3);
  rotated[i] = at.cosine * v[i] - at.sine * v[j];
  rotated[j] = at.sine * v[i] + at.cosine * v[j];
  return rotated;
}

/// From the parent's axes to the frame's.
template <class R>
RingVector3<R> to_frame(const FrameOf<R>& at, const RingVector3<R>& v) {
  const SymbolicFrame& frame = *at.frame;
  RingVector3<R> rotated;
  for (std::size_t k = 0; k < 3; ++k) {
    const R& component = v[static_cast<std::size_t>(frame.axes[k])];
    rotated[k] = frame.signs[k] > 0 ? component : -component;
  }
  if (frame.angle < 0) return rotated;
  const auto i = static_cast<std::size_t>((frame.axis + 1) % 3), j = static_cast<std::size_t>((frame.axis + 2) % 3);
  rotated[i] = at.cosine * v[i] + at.sine * v[j];
  rotated[j] = at.cosine * v[j] - at.sine * v[i];
  return rotated;
}

template <class R>
RingSymmetric3<R> to_parent(const FrameOf<R>& at, const RingSymmetric3<R>& I) {
  const SymbolicFrame& frame = *at.frame;
  RingSymmetric3<R> rotated;
  const auto parent_axis = [&](std::size_t k) { return static_cast<std::size_t>(frame.axes[k]); };
  for (std::size_t k = 0; k < 3; ++k) rotated[parent_axis(k)] = I[k];
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a + 1; b < 3; ++b) {
      const R& entry = I[off_diagonal_index(a, b)];
      rotated[off_diagonal_index(parent_axis(a), parent_axis(b))] =
          frame.signs[a] * frame.signs[b] > 0 ? entry : -entry;
    }
  if (frame.angle < 0) return rotated;
  const auto k = static_cast<std::size_t>(frame.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  const std::size_t ij = off_diagonal_index(i, j), ik = off_diagonal_index(i, k), jk = off_diagonal_index(j, k);
  const R &c = at.cosine, &s = at.sine;
  const R u = (I[i] - I[j]) * s + R(2) * (I[ij] * c);
  rotated[i] = I[i] - s * u;
  rotated[j] = I[j] + s * u;
  rotated[ij] = c * u - I[ij];
  rotated[ik] = c * I[ik] - s * I[jk];
  rotated[jk] = s * I[ik] + c * I[jk];
  return rotated;
}

template <class R>
RigidBodyInertia<R> to_parent(const FrameOf<R>& at, const RigidBodyInertia<R>& mass) {
  return shift_origin(RigidBodyInertia<R>{mass.mass, to_parent(at, mass.moment), to_parent(at, mass.inertia)},
                      at.offset);
}

/// Rate and acceleration of every variable over R.
template <class R>
struct VariableRates {
  std::vector<R> rate, acceleration;
};

/// Motion of one frame, in its axes, and the wrench that its joint transmits, about its origin.
template <class R>
struct FrameMotion {
  RingVector3<R> w, dw, a, force, couple;
};

/// Adds the forces of springs between points: positions are found in the world, forces in the frames' axes.
template <class R, class Maker>
void apply_point_springs(const SymbolicTree& tree, Maker& make, const std::vector<FrameOf<R>>& frames,
                         std::vector<FrameMotion<R>>& motions) {
  const auto parent = [&](int frame) { return tree.frames[static_cast<std::size_t>(frame)].parent; };
  const auto at = [&](int frame) -> const FrameOf<R>& { return frames[static_cast<std::size_t>(frame)]; };
  const auto in_world = [&](const FramePoint& point) {
    RingVector3<R> p = convert_vector<R>(point.at, make);
    for (int frame = point.frame; frame > 0; frame = parent(frame)) p = at(frame).offset + to_parent(at(frame), p);
    return p;
  };
  const auto in_frame = [&](int frame, RingVector3<R> v) {
    std::vector<int> chain;
    for (int k = frame; k > 0; k = parent(k)) chain.push_back(k);
    for (auto k = chain.rbegin(); k != chain.rend(); ++k) v = to_frame(at(*k), v);
    return v;
  };
  const auto apply_force = [&](const FramePoint& point, const RingVector3<R>& force) {
    FrameMotion<R>& m = motions[static_cast<std::size_t>(point.frame)];
    m.force = m.force + force;
    m.couple = m.couple + cross(convert_vector<R>(point.at, make), force);
  };
  for (const LinearSpring& spring : tree.springs) {
    const RingVector3<R> d = in_world(spring.b) - in_world(spring.a);
    R tension = make.convert(spring.stiffness);  // force per length
    if (spring.length >= 0)
      tension = tension - tension * make.convert(spring.free_length) * make.inverse(make.root(dot(d, d)));
    const RingVector3<R> force = scale_vector(tension, d);
    apply_force(spring.b, in_frame(spring.b.frame, force));
    apply_force(spring.a, in_frame(spring.a.frame, RingVector3<R>{-force[0], -force[1], -force[2]}));
  }
}

/// Torques of the columns, including weight and springs.
template <class R, class Maker>
std::vector<R> newton_euler_torques(const SymbolicTree& tree, Maker& make, const VariableRates<R>& rates) {
  using Motion = FrameMotion<R>;
  const RingVector3<R> zero{R(0), R(0), R(0)};
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  std::vector<Motion> motions(frames.size(), Motion{zero, zero, zero, zero, zero});
  motions[0].a = zero - convert_vector<R>(tree.gravity, make);
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const FrameOf<R>& at = frames[i];
    const SymbolicFrame& frame = *at.frame;
    const Motion& parent = motions[static_cast<std::size_t>(frame.parent)];
    Motion& m = motions[i];
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
  apply_point_springs(tree, make, frames, motions);
  std::vector<R> torque(tree.columns.size(), R(0));
  for (const JointSpring& spring : tree.joint_springs) {
    const R force = make.convert(spring.stiffness) * make.symbol(spring.symbol) - make.convert(spring.preload);
    for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(spring.variable)].follows)
      torque[static_cast<std::size_t>(column)] = torque[static_cast<std::size_t>(column)] + make.convert(ratio) * force;
  }
  for (std::size_t i = frames.size(); i-- > 1;) {
    const SymbolicFrame& frame = *frames[i].frame;
    const Motion& m = motions[i];
    if (frame.variable >= 0) {
      const R& joint_effort = (frame.angle >= 0 ? m.couple : m.force)[static_cast<std::size_t>(frame.axis)];
      for (const auto& [column, ratio] : tree.variables[static_cast<std::size_t>(frame.variable)].follows) {
        R& sum = torque[static_cast<std::size_t>(column)];
        const R contribution = make.convert(ratio) * joint_effort;
        sum = frame.sign > 0 ? sum + contribution : sum - contribution;
      }
    }
    Motion& parent = motions[static_cast<std::size_t>(frame.parent)];
    const RingVector3<R> force = to_parent(frames[i], m.force);
    parent.couple = parent.couple + (to_parent(frames[i], m.couple) + cross(frames[i].offset, force));
    parent.force = parent.force + force;
  }
  return torque;
}

// Composite rigid bodies and positions over any ring.
// Source: R. Featherstone, Rigid Body Dynamics Algorithms, section 6.2.

/// The mass matrix M of the tree in its columns.
/// @param total receives the inertia of all masses together, in the world's axes about its origin
template <class R, class Maker>
std::vector<std::vector<R>> composite_body_mass_matrix(const SymbolicTree& tree, Maker& make,
                                                       RigidBodyInertia<R>& total) {
  const std::size_t n = tree.columns.size();
  std::vector<std::vector<R>> M(n, std::vector<R>(n, R(0)));
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  std::vector<RigidBodyInertia<R>> composite;
  for (const FrameOf<R>& frame : frames) composite.push_back(frame.mass);
  const auto add = [&](const SymbolicFrame& descendant, const SymbolicFrame& ancestor, R x) {
    if (descendant.sign * ancestor.sign < 0) x = -x;
    for (const auto& [i, a] : tree.variables[static_cast<std::size_t>(descendant.variable)].follows)
      for (const auto& [j, b] : tree.variables[static_cast<std::size_t>(ancestor.variable)].follows) {
        const R y = make.convert(a) * make.convert(b) * x;
        const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
        M[row][column] = M[row][column] + y;
        if (&descendant != &ancestor) M[column][row] = M[column][row] + y;
      }
  };
  for (std::size_t i = frames.size(); i-- > 1;) {
    const SymbolicFrame& descendant = *frames[i].frame;
    const RigidBodyInertia<R>& c = composite[i];
    if (descendant.variable >= 0) {
      const auto axis = static_cast<std::size_t>(descendant.axis);
      const RingVector3<R> e = unit_vector(descendant.axis, R(1));
      // momenta for a unit rate of this joint
      RingVector3<R> p = descendant.angle >= 0 ? cross(e, c.moment) : unit_vector(descendant.axis, c.mass);
      RingVector3<R> L = descendant.angle >= 0 ? c.inertia * e : cross(c.moment, e);
      add(descendant, descendant, descendant.angle >= 0 ? L[axis] : p[axis]);
      for (std::size_t at = i; tree.frames[at].parent >= 0;) {
        p = to_parent(frames[at], p);
        L = to_parent(frames[at], L) + cross(frames[at].offset, p);
        at = static_cast<std::size_t>(tree.frames[at].parent);
        const SymbolicFrame& ancestor = *frames[at].frame;
        if (ancestor.variable >= 0)
          add(descendant, ancestor, (ancestor.angle >= 0 ? L : p)[static_cast<std::size_t>(ancestor.axis)]);
      }
    }
    composite[static_cast<std::size_t>(descendant.parent)] += to_parent(frames[i], c);
  }
  total = composite[0];
  return M;
}

/// Position of a point in world axes.
template <class R, class Maker>
RingVector3<R> world_position(const SymbolicTree& tree, Maker& make, const FramePoint& point) {
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  RingVector3<R> p = convert_vector<R>(point.at, make);
  for (int frame = point.frame; frame > 0; frame = tree.frames[static_cast<std::size_t>(frame)].parent)
    p = frames[static_cast<std::size_t>(frame)].offset + to_parent(frames[static_cast<std::size_t>(frame)], p);
  return p;
}

/// Direction of a frame's axis in world axes.
template <class R, class Maker>
RingVector3<R> world_direction(const SymbolicTree& tree, Maker& make, int frame, int axis) {
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  RingVector3<R> d = unit_vector(axis, R(1));
  for (int ancestor = frame; ancestor > 0; ancestor = tree.frames[static_cast<std::size_t>(ancestor)].parent)
    d = to_parent(frames[static_cast<std::size_t>(ancestor)], d);
  return d;
}

/// Equations h = 0 of all closures, in the engine's order. Source: docs/theory.md, loops.
template <class R, class Maker>
std::vector<R> closure_equations(const SymbolicTree& tree, Maker& make) {
  std::vector<R> rows;
  for (const LoopClosure& joint : tree.closures) {
    using enum JointType;
    const RingVector3<R> d = world_position<R>(tree, make, joint.b) - world_position<R>(tree, make, joint.a);
    const auto axis = [&](const FramePoint& point, int k) { return world_direction<R>(tree, make, point.frame, k); };
    const auto add_axial_row = [&](int k) { rows.push_back(dot(axis(joint.a, k), d)); };
    const auto add_perpendicular_row = [&](int i, int j) { rows.push_back(dot(axis(joint.a, i), axis(joint.b, j))); };
    const JointType type = joint.type;
    if (type == revolute || type == fixed || type == spherical || type == universal)
      for (std::size_t k = 0; k < (tree.is_planar ? 2U : 3U); ++k) rows.push_back(d[k]);
    if (tree.is_planar) {
      if (type == prismatic || type == pin_slot) add_axial_row(1);
      if (type == prismatic || type == fixed) add_perpendicular_row(1, 0);
      continue;
    }
    if (type == cylindrical || type == prismatic) add_axial_row(0), add_axial_row(1);
    if (type == JointType::planar) add_axial_row(2);
    if (type == revolute || type == cylindrical || type == JointType::planar)
      add_perpendicular_row(0, 2), add_perpendicular_row(1, 2);
    if (type == prismatic || type == fixed)
      add_perpendicular_row(1, 2), add_perpendicular_row(2, 0), add_perpendicular_row(0, 1);
    if (type == universal) add_perpendicular_row(2, 0);
  }
  return rows;
}

}  // namespace balance::formulas
