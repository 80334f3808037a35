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

}  // namespace balance::formulas
