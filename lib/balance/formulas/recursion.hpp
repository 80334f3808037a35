#pragma once
/// Composite bodies and places over any ring. Source: R. Featherstone, Rigid Body
/// Dynamics Algorithms, section 6.2. Private to formulas.

#include "balance/formulas/frames_over.hpp"

#include <vector>

namespace balance::formulas {

/// M of the tree in its columns.
/// @param whole receives all masses together, in the world's axes about its origin
template <class R, class Maker>
std::vector<std::vector<R>> composite_body_mass_matrix(const SymbolicTree& tree, Maker& make,
                                                       RigidBodyInertia<R>& whole) {
  const std::size_t n = tree.columns.size();
  std::vector<std::vector<R>> M(n, std::vector<R>(n, R(0)));
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  std::vector<RigidBodyInertia<R>> composite;
  for (const FrameOf<R>& frame : frames) composite.push_back(frame.mass);
  const auto add = [&](const SymbolicFrame& low, const SymbolicFrame& high, R x) {
    if (low.sign * high.sign < 0) x = -x;
    for (const auto& [i, a] : tree.variables[static_cast<std::size_t>(low.variable)].follows)
      for (const auto& [j, b] : tree.variables[static_cast<std::size_t>(high.variable)].follows) {
        const R y = make.convert(a) * make.convert(b) * x;
        const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
        M[row][column] = M[row][column] + y;
        if (&low != &high) M[column][row] = M[column][row] + y;
      }
  };
  for (std::size_t i = frames.size(); i-- > 1;) {
    const SymbolicFrame& low = *frames[i].frame;
    const RigidBodyInertia<R>& c = composite[i];
    if (low.variable >= 0) {
      const auto axis = static_cast<std::size_t>(low.axis);
      const RingVector3<R> e = unit_vector(low.axis, R(1));
      // momenta for a unit rate of this joint
      RingVector3<R> p = low.angle >= 0 ? cross(e, c.moment) : unit_vector(low.axis, c.mass);
      RingVector3<R> L = low.angle >= 0 ? c.inertia * e : cross(c.moment, e);
      add(low, low, low.angle >= 0 ? L[axis] : p[axis]);
      for (std::size_t at = i; tree.frames[at].parent >= 0;) {
        p = to_parent(frames[at], p);
        L = to_parent(frames[at], L) + cross(frames[at].offset, p);
        at = static_cast<std::size_t>(tree.frames[at].parent);
        const SymbolicFrame& high = *frames[at].frame;
        if (high.variable >= 0) add(low, high, (high.angle >= 0 ? L : p)[static_cast<std::size_t>(high.axis)]);
      }
    }
    composite[static_cast<std::size_t>(low.parent)] += to_parent(frames[i], c);
  }
  whole = composite[0];
  return M;
}

/// A place in the world's axes.
template <class R, class Maker>
RingVector3<R> world_position(const SymbolicTree& tree, Maker& make, const FramePoint& place) {
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  RingVector3<R> p = convert_vector<R>(place.at, make);
  for (int at = place.frame; at > 0; at = tree.frames[static_cast<std::size_t>(at)].parent)
    p = frames[static_cast<std::size_t>(at)].offset + to_parent(frames[static_cast<std::size_t>(at)], p);
  return p;
}

/// A direction in a frame's axes, in the world's.
template <class R, class Maker>
RingVector3<R> world_direction(const SymbolicTree& tree, Maker& make, int frame, int axis) {
  const std::vector<FrameOf<R>> frames = make_frames<R>(tree, make);
  RingVector3<R> d = unit_vector(axis, R(1));
  for (int at = frame; at > 0; at = tree.frames[static_cast<std::size_t>(at)].parent)
    d = to_parent(frames[static_cast<std::size_t>(at)], d);
  return d;
}

}  // namespace balance::formulas
