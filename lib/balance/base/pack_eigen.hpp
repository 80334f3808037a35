#pragma once
/// Packs as scalars of Eigen's small vectors and matrices, mixed with numbers that are the same in every lane.

#include "balance/base/pack.hpp"
#include "balance/base/types.hpp"

/// A pack that lies across two lines of the processor's cache is read twice.
template <int W>
inline constexpr std::size_t balance::storage_alignment<balance::Pack<W>> = sizeof(double) * W;

/// All lanes move the same mechanism.
template <int W>
struct balance::ModelScalarTraits<balance::Pack<W>> {
  using Type = double;
};

template <int W>
struct Eigen::NumTraits<balance::Pack<W>> : Eigen::NumTraits<double> {
  using Real = balance::Pack<W>;
  using NonInteger = balance::Pack<W>;
  using Nested = balance::Pack<W>;
  using Literal = balance::Pack<W>;
};

template <int W, class Operation>
struct Eigen::ScalarBinaryOpTraits<balance::Pack<W>, double, Operation> {
  using ReturnType = balance::Pack<W>;
};
template <int W, class Operation>
struct Eigen::ScalarBinaryOpTraits<double, balance::Pack<W>, Operation> {
  using ReturnType = balance::Pack<W>;
};
