#pragma once
/// Rows of numbers that are added and multiplied together: the derivatives of a Dual.

#include <cstddef>
#include <utility>

namespace balance {

namespace duals {

/// What every x86-64 processor works on at once, aligned like one number. The same for every source: programs that use the library may be
/// compiled for other processors than it is.
using Pair __attribute__((vector_size(16), aligned(8), may_alias)) = double;

template <int N, bool Even = N % 2 == 0>
struct DerivativeStorage {
  static constexpr int count = N / 2;
  Pair parts[count] = {};
};
template <int N>
struct DerivativeStorage<N, false> {
  static constexpr int count = N;
  double parts[count] = {};
};

}  // namespace duals

/// N numbers, in memory one after another on every processor.
template <int N>
class Derivatives {
 public:
  static constexpr std::size_t size() { return N; }
  double& operator[](std::size_t i) { return begin()[i]; }
  double operator[](std::size_t i) const { return begin()[i]; }
  double* begin() { return reinterpret_cast<double*>(row_.parts); }
  double* end() { return begin() + N; }
  const double* begin() const { return reinterpret_cast<const double*>(row_.parts); }
  const double* end() const { return begin() + N; }

  Derivatives& operator+=(const Derivatives& b) { return *this = *this + b; }
  Derivatives& operator-=(const Derivatives& b) { return *this = *this - b; }
  friend Derivatives operator+(const Derivatives& a, const Derivatives& b) {
    return each([&](int i) { return a.row_.parts[i] + b.row_.parts[i]; });
  }
  friend Derivatives operator-(const Derivatives& a, const Derivatives& b) {
    return each([&](int i) { return a.row_.parts[i] - b.row_.parts[i]; });
  }
  friend Derivatives operator*(const Derivatives& a, double b) {
    return each([&](int i) { return a.row_.parts[i] * b; });
  }
  friend Derivatives operator*(double a, const Derivatives& b) { return b * a; }
  friend Derivatives operator/(const Derivatives& a, double b) {
    return each([&](int i) { return a.row_.parts[i] / b; });
  }

 private:
  template <class Part>
  static Derivatives each(const Part& part) {
    return all(part, std::make_integer_sequence<int, duals::DerivativeStorage<N>::count>());
  }
  // Not a loop: compilers keep what is counted by one in memory, and this in registers.
  template <class Part, int... I>
  static Derivatives all(const Part& part, std::integer_sequence<int, I...>) {
    Derivatives out;
    ((out.row_.parts[I] = part(I)), ...);
    return out;
  }

  duals::DerivativeStorage<N> row_;
};

}  // namespace balance
