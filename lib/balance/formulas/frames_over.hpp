#pragma once
/// The frames of a tree over any ring R of scalars. A ring's maker knows what its numbers are:
///
///     R of(const Polynomial&)          a polynomial of symbols alone
///     R circular(int angle, bool sine) cos or sin of an angle
///     R symbol(int index)
///
/// Private to formulas.

#include "balance/formulas/symbolic_tree.hpp"

#include <vector>

namespace balance::formulas {

/// What the recursions know of one frame over R.
template <class R>
struct FrameOf {
  const SymbolicFrame* frame = nullptr;
  RingVector3<R> offset;  ///< in the parent's axes, slide included
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
    FrameOf<R> over;
    over.frame = &frame;
    over.offset = convert_vector<R>(frame.offset, make);
    if (frame.slide >= 0) {
      R& along = over.offset[static_cast<std::size_t>(frame.axis)];
      along = frame.sign > 0 ? along + make.symbol(frame.slide) : along - make.symbol(frame.slide);
    }
    if (frame.angle >= 0) {
      over.cosine = make.circular(frame.angle, false);
      over.sine = make.circular(frame.angle, true);
      if (frame.sign < 0) over.sine = -over.sine;
    }
    over.mass.mass = make.convert(frame.mass.mass);
    over.mass.moment = convert_vector<R>(frame.mass.moment, make);
    for (std::size_t k = 0; k < 6; ++k) over.mass.inertia[k] = make.convert(frame.mass.inertia[k]);
    frames.push_back(std::move(over));
  }
  return frames;
}

/// A frame's axes → its parent's.
template <class R>
RingVector3<R> to_parent(const FrameOf<R>& at, const RingVector3<R>& v) {
  const SymbolicFrame& frame = *at.frame;
  RingVector3<R> turned;
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
RingVector3<R> to_frame(const FrameOf<R>& at, const RingVector3<R>& v) {
  const SymbolicFrame& frame = *at.frame;
  RingVector3<R> turned;
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
RingSymmetric3<R> to_parent(const FrameOf<R>& at, const RingSymmetric3<R>& I) {
  const SymbolicFrame& frame = *at.frame;
  RingSymmetric3<R> turned;
  const auto place = [&](std::size_t k) { return static_cast<std::size_t>(frame.axes[k]); };
  for (std::size_t k = 0; k < 3; ++k) turned[place(k)] = I[k];
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = a + 1; b < 3; ++b) {
      const R& entry = I[off_diagonal_index(a, b)];
      turned[off_diagonal_index(place(a), place(b))] = frame.signs[a] * frame.signs[b] > 0 ? entry : -entry;
    }
  if (frame.angle < 0) return turned;
  const auto k = static_cast<std::size_t>(frame.axis), i = (k + 1) % 3, j = (k + 2) % 3;
  const std::size_t ij = off_diagonal_index(i, j), ik = off_diagonal_index(i, k), jk = off_diagonal_index(j, k);
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
RigidBodyInertia<R> to_parent(const FrameOf<R>& at, const RigidBodyInertia<R>& mass) {
  return shift_origin(RigidBodyInertia<R>{mass.mass, to_parent(at, mass.moment), to_parent(at, mass.inertia)},
                      at.offset);
}

}  // namespace balance::formulas
