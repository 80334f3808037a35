#pragma once
/// Composite bodies and Newton–Euler over any ring R of scalars. A ring's maker knows what its numbers are:
///
///     R of(const Polynomial&)          a polynomial of symbols alone
///     R circular(int angle, bool sine) cos or sin of an angle
///     R symbol(int index)
///
/// Source: R. Featherstone, Rigid Body Dynamics Algorithms, sections 5.3 and 6.2. Private to formulas.

#include "balance/formulas/symbolic_tree.hpp"

#include <vector>

namespace balance::formulas {

/// What the recursions know of one frame over R.
template <class R>
struct FrameOf {
  const Frame* frame = nullptr;
  Triple<R> offset;  ///< in the parent's axes, slide included
  R cosine = R(1), sine = R(0);
  MassOf<R> mass;
};

template <class R, class Maker>
Triple<R> made(const Vector& v, Maker& make) {
  return {make.of(v[0]), make.of(v[1]), make.of(v[2])};
}

template <class R, class Maker>
std::vector<FrameOf<R>> frames_over(const SymbolicTree& tree, Maker& make) {
  std::vector<FrameOf<R>> frames;
  for (const Frame& frame : tree.frames) {
    FrameOf<R> over;
    over.frame = &frame;
    over.offset = made<R>(frame.offset, make);
    if (frame.slide >= 0) {
      R& along = over.offset[static_cast<std::size_t>(frame.axis)];
      along = frame.sign > 0 ? along + make.symbol(frame.slide) : along - make.symbol(frame.slide);
    }
    if (frame.angle >= 0) {
      over.cosine = make.circular(frame.angle, false);
      over.sine = make.circular(frame.angle, true);
      if (frame.sign < 0) over.sine = -over.sine;
    }
    over.mass.mass = make.of(frame.mass.mass);
    over.mass.moment = made<R>(frame.mass.moment, make);
    for (std::size_t k = 0; k < 6; ++k) over.mass.inertia[k] = make.of(frame.mass.inertia[k]);
    frames.push_back(std::move(over));
  }
  return frames;
}

/// A frame's axes → its parent's.
template <class R>
Triple<R> up(const FrameOf<R>& at, const Triple<R>& v) {
  const Frame& frame = *at.frame;
  Triple<R> turned;
  for (std::size_t k = 0; k < 3; ++k)
    turned[static_cast<std::size_t>(frame.axes[k])] = frame.signs[k] > 0 ? v[k] : -v[k];
  if (frame.angle < 0) return turned;
  const auto i = static_cast<std::size_t>((frame.axis + 1) % 3), j = static_cast<std::size_t>((frame.axis + 2) % 3);
  turned[i] = at.cosine * v[i] - at.sine * v[j];
  turned[j] = at.sine * v[i] + at.cosine * v[j];
  return turned;
}

/// A parent's axes → the frame's.
template <class R>
Triple<R> down(const FrameOf<R>& at, const Triple<R>& v) {
  const Frame& frame = *at.frame;
  Triple<R> turned;
  for (std::size_t k = 0; k < 3; ++k) {
    const R& component = v[static_cast<std::size_t>(frame.axes[k])];
    turned[k] = frame.signs[k] > 0 ? component : -component;
  }
  if (frame.angle < 0) return turned;
  const auto i = static_cast<std::size_t>((frame.axis + 1) % 3), j = static_cast<std::size_t>((frame.axis + 2) % 3);
  turned[i] = at.cosine * v[i] + at.sine * v[j];
  turned[j] = at.cosine * v[j] - at.sine * v[i];
  return turned;
}

template <class R>
Symmetric<R> up(const FrameOf<R>& at, const Symmetric<R>& I) {
  const Frame& frame = *at.frame;
  Symmetric<R> turned;
  const auto place = [&](std::size_t k) { return static_cast<std::size_t>(frame.axes[k]); };
  for (std::size_t k = 0; k < 3; ++k) turned[place(k)] = I[k];
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a + 1; b < 3; ++b) {
      const R& entry = I[off_diagonal(a, b)];
      turned[off_diagonal(place(a), place(b))] = frame.signs[a] * frame.signs[b] > 0 ? entry : -entry;
    }
  if (frame.angle < 0) return turned;
  const auto k = static_cast<std::size_t>(frame.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  const std::size_t ij = off_diagonal(i, j), ik = off_diagonal(i, k), jk = off_diagonal(j, k);
  const R &c = at.cosine, &s = at.sine;
  const R u = (I[i] - I[j]) * s + R(2) * (I[ij] * c);
  turned[i] = I[i] - s * u;
  turned[j] = I[j] + s * u;
  turned[ij] = c * u - I[ij];
  turned[ik] = c * I[ik] - s * I[jk];
  turned[jk] = s * I[ik] + c * I[jk];
  return turned;
}

template <class R>
MassOf<R> up(const FrameOf<R>& at, const MassOf<R>& mass) {
  return shifted(MassOf<R>{mass.mass, up(at, mass.moment), up(at, mass.inertia)}, at.offset);
}

/// M of the tree in its columns.
/// @param whole receives all masses together, in the world's axes about its origin
template <class R, class Maker>
std::vector<std::vector<R>> mass_matrix(const SymbolicTree& tree, Maker& make, MassOf<R>& whole) {
  const std::size_t n = tree.columns.size();
  std::vector<std::vector<R>> M(n, std::vector<R>(n, R(0)));
  const std::vector<FrameOf<R>> frames = frames_over<R>(tree, make);
  std::vector<MassOf<R>> composite;
  for (const FrameOf<R>& frame : frames) composite.push_back(frame.mass);
  const auto add = [&](const Frame& low, const Frame& high, R x) {
    if (low.sign * high.sign < 0) x = -x;
    for (const auto& [i, a] : tree.variables[static_cast<std::size_t>(low.variable)].follows)
      for (const auto& [j, b] : tree.variables[static_cast<std::size_t>(high.variable)].follows) {
        const R y = make.of(a) * make.of(b) * x;
        const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
        M[row][column] = M[row][column] + y;
        if (&low != &high) M[column][row] = M[column][row] + y;
      }
  };
  for (std::size_t i = frames.size(); i-- > 1;) {
    const Frame& low = *frames[i].frame;
    const MassOf<R>& c = composite[i];
    if (low.variable >= 0) {
      const auto axis = static_cast<std::size_t>(low.axis);
      const Triple<R> e = unit_vector(low.axis, R(1));
      // momenta for a unit rate of this joint
      Triple<R> p = low.angle >= 0 ? cross(e, c.moment) : unit_vector(low.axis, c.mass);
      Triple<R> L = low.angle >= 0 ? c.inertia * e : cross(c.moment, e);
      add(low, low, low.angle >= 0 ? L[axis] : p[axis]);
      for (std::size_t at = i; tree.frames[at].parent >= 0;) {
        p = up(frames[at], p);
        L = up(frames[at], L) + cross(frames[at].offset, p);
        at = static_cast<std::size_t>(tree.frames[at].parent);
        const Frame& high = *frames[at].frame;
        if (high.variable >= 0) add(low, high, (high.angle >= 0 ? L : p)[static_cast<std::size_t>(high.axis)]);
      }
    }
    composite[static_cast<std::size_t>(low.parent)] += up(frames[i], c);
  }
  whole = composite[0];
  return M;
}

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

/// A place in the world's axes.
template <class R, class Maker>
Triple<R> position(const SymbolicTree& tree, Maker& make, const Place& place) {
  const std::vector<FrameOf<R>> frames = frames_over<R>(tree, make);
  Triple<R> p = made<R>(place.at, make);
  for (int at = place.frame; at > 0; at = tree.frames[static_cast<std::size_t>(at)].parent)
    p = frames[static_cast<std::size_t>(at)].offset + up(frames[static_cast<std::size_t>(at)], p);
  return p;
}

/// A direction in a frame's axes, in the world's.
template <class R, class Maker>
Triple<R> direction(const SymbolicTree& tree, Maker& make, int frame, int axis) {
  const std::vector<FrameOf<R>> frames = frames_over<R>(tree, make);
  Triple<R> d = unit_vector(axis, R(1));
  for (int at = frame; at > 0; at = tree.frames[static_cast<std::size_t>(at)].parent)
    d = up(frames[static_cast<std::size_t>(at)], d);
  return d;
}

}  // namespace balance::formulas
